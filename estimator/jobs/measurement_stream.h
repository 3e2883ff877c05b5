#pragma once
#include <deque>
#include <future>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimator/live/frame_deadline.h"
#include "estimator/online/camera_image.h"
#include "estimator/online/config.h"
#include "estimator/online/measure_frame.h"
#include "estimator/online/online_options.h"
#include "estimator/result/run_facts.h"
#include "frontend/base/spans.h"
#include "frontend/front_end.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/pattern/corner_refiner.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/tags/tag_sweep.h"
#include "frontend/types/measured_tags.h"

namespace tagtwist::internal {

/// One frame of a recording, measured, and what it took.
struct MeasuredFrame {
  FrameMeasurements measurements;
  std::vector<FrameMeasurements> of_others = {};  // of Config::bodies
  std::string image_problem;  // "path: cannot decode"; empty when the image is fine or not needed
  double detect_ms = 0, track_ms = 0, seed_ms = 0;
  std::vector<CameraImage> images = {};  // of the cameras that took it, ascending
};

/// One frame of a recording, and the tags that were found in it.
struct SearchedFrame {
  Frame frame;
  std::vector<TagDetection> tags;
  double detect_ms = 0;
  std::vector<int> doubled_ids = {};
  std::vector<SearchedFrame> others = {};  // of a rig's other cameras at the same time
};

/// The times of that frame's stages, and so far of the frame.
inline void AddStageTimes(const MeasuredFrame& frame, StageTimes* times) {
  times->detect_ms.push_back(frame.detect_ms);
  times->track_ms.push_back(frame.track_ms);
  times->seed_ms.push_back(frame.seed_ms);
  times->frame_ms.push_back(frame.detect_ms + frame.track_ms + frame.seed_ms);
}

/// The source's next frame, nullopt at the end. An error, which names it: an image that is not of
/// its camera's size.
Result<std::optional<Frame>> NextFrame(DataSource* source, const Rig& rig,
                                       SpanObserver* spans = nullptr);  // told of "read"

/// How a recording is measured.
struct StreamOptions {
  bool use_detections = false;  // the recording's own corners count
  int threads = 1;              // images searched at once; the result does not depend on it
  /// Of images: kFull searches each, else TagSweep goes over pieces of them where the detector's
  /// options refine patterns. What is guided by states cannot be measured ahead:
  /// OnlineEstimator::AddImage.
  DetectionMode detection = DetectionMode::kFull;
  const MeasuredTags* measured = nullptr;  // these tags count, and no image is searched
  /// No frame is read beyond so many, or so long after the first one.
  size_t max_frames = std::numeric_limits<size_t>::max();
  int64_t duration_ns = std::numeric_limits<int64_t>::max();
  SpanObserver* spans = nullptr;  // told of "read", "detect", "track" and "closed form"
};

/// How many images StreamOptions of that detection go over together, counted from the first frame.
size_t FramesPerPiece(const Config& config, DetectionMode detection);

/// Runs the frontend over a recording. With more than one thread the tags of the next frames, or
/// pieces of them, are detected ahead while this frame's tracks are followed. What `measured`
/// points to must outlive the stream. Of a rig each camera's images are searched by themselves, the
/// tags and tracks of all cameras at one time are one frame's, the closed form is that of the first
/// camera that has any. Cameras that stand have no tracks. Of several bodies the tags are parted.
class MeasurementStream {
 public:
  static Result<MeasurementStream> Create(DataSource* source, const Config& config,
                                          const StreamOptions& options);

  /// Frames are measured under this deadline from now on; it must outlive the stream.
  void SetDeadline(FrameDeadline* deadline) { deadline_ = deadline; }

  /// The next frame, nullopt at the end.
  Result<std::optional<MeasuredFrame>> Next();
  /// The next frame's tags alone; who asks for them asks for nothing else.
  Result<std::optional<SearchedFrame>> NextDetected();

 private:
  using Piece = std::vector<SearchedFrame>;

  // What tasks read: it stays where it is, and does not change.
  struct Shared {
    Config config;
    TagMap all_tags;                      // of every body
    std::vector<CornerRefiner> refiners;  // of each camera
    StreamOptions options;
  };
  // What a task has for itself.
  struct Searcher {
    std::optional<TagDetector> detector;  // each image by itself,
    std::vector<TagSweep> sweeps;         // or a piece of them, of each camera
  };

  MeasurementStream(DataSource* source, std::unique_ptr<const Shared> shared,
                    std::vector<Searcher> searchers);
  std::vector<Frame> ReadPiece();
  void FillQueue();
  // What is seen of one of the bodies; of the only one it leaves the frame without its tags.
  DetectedFrame TakeSeenOf(size_t body, SearchedFrame* searched) const;
  MeasuredFrame Measure(SearchedFrame* searched, size_t tags_elsewhere);
  static Piece Detect(std::vector<Frame> frames, const Shared& shared, Searcher* searcher);
  static Piece Sweep(std::vector<Frame> frames, std::vector<TagSweep>* sweeps);
  static SearchedFrame DetectOne(Frame frame, const Shared& shared, const Searcher& searcher);

  DataSource* source_;
  std::unique_ptr<const Shared> shared_;
  std::vector<Searcher> searchers_;  // one for each piece under way, in turn
  size_t next_searcher_ = 0;
  size_t n_read_ = 0;
  std::optional<int64_t> first_ns_;
  bool at_end_ = false;
  Status end_ = Ok();                  // an error that ended the recording, after the frames before
  FrameDeadline* deadline_ = nullptr;  // none
  std::vector<std::vector<FrontEnd>> front_ends_;  // of each body, of each camera
  std::deque<SearchedFrame> ready_;
  std::deque<std::future<Piece>> queue_;  // last member: tasks end before what they read
};

}  // namespace tagtwist::internal
