#pragma once
#include <deque>
#include <future>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estimator/live/frame_deadline.h"
#include "estimator/online/config.h"
#include "estimator/result/run_facts.h"
#include "frontend/front_end.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/pattern/corner_refiner.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/measured_tags.h"

namespace tagtwist::internal {

/// One frame of a recording, measured, and what it took.
struct MeasuredFrame {
  FrameMeasurements measurements;
  std::string image_problem;  // "path: cannot decode"; empty when the image is fine or not needed
  double detect_ms = 0, track_ms = 0, seed_ms = 0;
  cv::Mat image;  // 8-bit gray; empty: none was read
};

/// One frame of a recording, and the tags that were found in it.
struct SearchedFrame {
  Frame frame;
  std::vector<TagDetection> tags;
  double detect_ms = 0;
  std::vector<int> doubled_ids = {};
};

/// The times of that frame's stages, and so far of the frame.
void AddStageTimes(const MeasuredFrame& frame, StageTimes* times);

/// The source's next frame, nullopt at the end. An error, which names it: an image that is not of
/// the camera's size.
Result<std::optional<Frame>> NextFrame(DataSource* source, const Camera& camera);

/// Runs the frontend over a recording. With more than one thread the tags of the next frames are
/// detected ahead while this frame's tracks are followed; results do not depend on it. With
/// `measured`, which must outlive the stream, no image is searched: its tags count. What is
/// guided by states cannot be measured ahead: OnlineEstimator::AddImage.
class MeasurementStream {
 public:
  static Result<MeasurementStream> Create(DataSource* source, const Config& config,
                                          bool use_detections, int threads,
                                          const MeasuredTags* measured = nullptr);

  /// Frames are measured under this deadline from now on; it must outlive the stream.
  void SetDeadline(FrameDeadline* deadline) { deadline_ = deadline; }

  /// The next frame, nullopt at the end.
  Result<std::optional<MeasuredFrame>> Next();
  /// The next frame's tags alone; who asks for them asks for nothing else.
  Result<std::optional<SearchedFrame>> NextDetected();

 private:
  using Pending = std::future<SearchedFrame>;

  // What tasks read: it stays where it is, and does not change.
  struct Shared {
    Config config;
    CornerRefiner refiner;
    const MeasuredTags* measured;  // nullptr: images are searched
  };

  MeasurementStream(DataSource* source, std::unique_ptr<const Shared> shared, bool use_detections,
                    std::vector<TagDetector> detectors);
  Status FillQueue();
  static SearchedFrame Detect(Frame frame, const TagDetector& detector, const Shared& shared,
                              bool use_detections);

  DataSource* source_;
  std::unique_ptr<const Shared> shared_;
  bool use_detections_;
  std::vector<TagDetector> detectors_;  // one for each frame under way, in turn
  size_t next_detector_ = 0;
  bool at_end_ = false;
  FrameDeadline* deadline_ = nullptr;  // none
  FrontEnd front_end_;
  std::deque<Pending> queue_;  // last member: tasks end before what they read
};

}  // namespace tagtwist::internal
