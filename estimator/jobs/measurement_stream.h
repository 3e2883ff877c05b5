#pragma once
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimator/live/frame_deadline.h"
#include "estimator/online/config.h"
#include "frontend/front_end.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/pattern/corner_refiner.h"
#include "frontend/tags/tag_follower.h"

namespace tagtwist {

/// One frame of a recording, measured, and what it took.
struct MeasuredFrame {
  FrameMeasurements measurements;
  std::string image_problem;  // "path: cannot decode"; empty when the image is fine or not needed
  double detect_ms = 0, track_ms = 0, seed_ms = 0;
};

/// Where the body is expected to be at a stamp; nullopt where nobody knows.
using PosePredictor = std::function<std::optional<PosePrediction>(int64_t t_ns)>;

/// Runs the frontend over a recording. With more than one thread the tags of the next frames are
/// detected ahead while this frame's tracks are followed; results do not depend on it. With a
/// predictor each frame's tags are found where it says (TagFollower), so none is measured ahead.
class MeasurementStream {
 public:
  static Result<MeasurementStream> Create(DataSource* source, const Config& config,
                                          bool use_detections, int threads);
  static Result<MeasurementStream> CreateGuided(DataSource* source, const Config& config,
                                                PosePredictor predict);

  /// Frames are measured under this deadline from now on; it must outlive the stream.
  void SetDeadline(FrameDeadline* deadline) { deadline_ = deadline; }

  /// The next frame, nullopt at the end.
  Result<std::optional<MeasuredFrame>> Next();

 private:
  struct Detected {
    Frame frame;
    std::vector<TagDetection> tags;
    double detect_ms = 0;
    bool cut_short = false;
  };
  using Pending = std::future<Detected>;

  // What tasks read: it stays where it is, and does not change.
  struct Shared {
    Config config;
    CornerRefiner refiner;
  };

  MeasurementStream(DataSource* source, std::unique_ptr<const Shared> shared, bool use_detections,
                    std::vector<TagDetector> detectors);
  Result<std::optional<Frame>> NextFrame();
  Result<std::optional<Detected>> NextDetected();
  Result<std::optional<Detected>> NextGuided();
  Status FillQueue();
  static Detected Detect(Frame frame, const TagDetector& detector, const Shared& shared,
                         bool use_detections);

  DataSource* source_;
  std::unique_ptr<const Shared> shared_;
  bool use_detections_;
  std::vector<TagDetector> detectors_;  // one for each frame under way, in turn
  size_t next_detector_ = 0;
  bool at_end_ = false;
  std::optional<TagFollower> follower_;  // guided
  PosePredictor predict_;                // of the window, for guided detection
  FrameDeadline* deadline_ = nullptr;    // none
  FrontEnd front_end_;
  std::deque<Pending> queue_;  // last member: tasks end before what they read
};

}  // namespace tagtwist
