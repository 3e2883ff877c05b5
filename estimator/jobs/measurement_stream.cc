#include "estimator/jobs/measurement_stream.h"

#include <algorithm>
#include <utility>

#include "estimator/live/stopwatch.h"
#include "estimator/online/image_size.h"
#include "estimator/online/measure_frame.h"
#include "frontend/tags/find_tags.h"

namespace tagtwist::internal {

Result<std::optional<Frame>> NextFrame(DataSource* source, const Camera& camera) {
  auto frame = source->Next();
  if (!frame || !*frame) return frame;
  if (const auto problem = ImageSizeProblem((*frame)->image, camera)) {
    return Error{(*frame)->name + ": " + *problem};
  }
  return frame;
}

namespace {

// Ids that a frame's own detections double, and those that it tells of besides.
std::vector<int> DoubledIdsOf(const Frame& frame, const TagMap& map) {
  std::vector<int> out = DoubledIds(frame.detections, map);
  for (const int id : frame.doubled_ids) {
    if (map.Find(id) != nullptr) out.push_back(id);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace

void AddStageTimes(const MeasuredFrame& frame, StageTimes* times) {
  times->detect_ms.push_back(frame.detect_ms);
  times->track_ms.push_back(frame.track_ms);
  times->seed_ms.push_back(frame.seed_ms);
  times->frame_ms.push_back(frame.detect_ms + frame.track_ms + frame.seed_ms);
}

Result<MeasurementStream> MeasurementStream::Create(DataSource* source, const Config& config,
                                                    bool use_detections, int threads,
                                                    const MeasuredTags* measured) {
  std::vector<TagDetector> detectors;
  for (int i = 0; i < std::max(1, threads); ++i) {
    auto detector = TagDetector::Create(config.set_up.map.family(), config.front_end.detector);
    if (!detector) return detector.error();
    detectors.push_back(std::move(*detector));
  }
  auto refiner = CornerRefiner::Create(config.set_up.map, config.set_up.rig.front().camera);
  if (!refiner) return refiner.error();
  return MeasurementStream(
      source, std::make_unique<const Shared>(Shared{config, std::move(*refiner), measured}),
      use_detections, std::move(detectors));
}

MeasurementStream::MeasurementStream(DataSource* source, std::unique_ptr<const Shared> shared,
                                     bool use_detections, std::vector<TagDetector> detectors)
    : source_(source),
      shared_(std::move(shared)),
      use_detections_(use_detections),
      detectors_(std::move(detectors)),
      front_end_(shared_->config.set_up, shared_->config.front_end) {}

SearchedFrame MeasurementStream::Detect(Frame frame, const TagDetector& detector,
                                        const Shared& shared, bool use_detections) {
  const Stopwatch watch;
  const Config& config = shared.config;
  const TagDetectorOptions& options = config.front_end.detector;
  SearchedFrame out;
  if (shared.measured != nullptr) {
    const auto tags = shared.measured->find(frame.t_ns);
    if (tags != shared.measured->end()) {
      out.tags = tags->second.tags;
      out.doubled_ids = tags->second.doubled_ids;
    }
    out.frame = std::move(frame);
    return out;
  }
  out.tags = use_detections ? FilterTags(frame.detections, config.set_up.map,
                                         config.set_up.rig.front().camera, options.border_px)
                            : FindTags(frame.image, detector, shared.refiner, config.set_up.map,
                                       config.set_up.rig.front().camera, options, &out.doubled_ids);
  if (use_detections) out.doubled_ids = DoubledIdsOf(frame, config.set_up.map);
  out.frame = std::move(frame);
  out.detect_ms = watch.ElapsedMs();
  return out;
}

Status MeasurementStream::FillQueue() {
  // One frame under way a detector; with a single thread each is measured when it is asked for.
  const auto policy = detectors_.size() > 1 ? std::launch::async : std::launch::deferred;
  while (!at_end_ && queue_.size() < detectors_.size()) {
    auto frame = NextFrame(source_, shared_->config.set_up.rig.front().camera);
    if (!frame) return frame.error();
    if (!*frame) {
      at_end_ = true;
      break;
    }
    const TagDetector* const detector = &detectors_[next_detector_];
    next_detector_ = (next_detector_ + 1) % detectors_.size();
    queue_.push_back(std::async(policy, [frame = std::move(**frame), detector,
                                         shared = shared_.get(), use = use_detections_]() mutable {
      return Detect(std::move(frame), *detector, *shared, use);
    }));
  }
  return Ok();
}

Result<std::optional<SearchedFrame>> MeasurementStream::NextDetected() {
  if (const auto filled = FillQueue(); !filled) return filled.error();
  if (queue_.empty()) return std::optional<SearchedFrame>();
  if (deadline_ != nullptr) deadline_->Start();
  std::optional<SearchedFrame> out = queue_.front().get();
  queue_.pop_front();
  return out;
}

Result<std::optional<MeasuredFrame>> MeasurementStream::Next() {
  auto next = NextDetected();
  if (!next) return next.error();
  if (!*next) return std::optional<MeasuredFrame>();
  SearchedFrame& detected = **next;
  const Frame& frame = detected.frame;
  MeasuredFrame out;
  out.detect_ms = detected.detect_ms;
  out.image = frame.image;
  if (!frame.image_problem.empty()) out.image_problem = frame.name + ": " + frame.image_problem;
  OnlineOptions options;
  if (deadline_ != nullptr) options.detection_time_up = deadline_->ForDetection();
  Stopwatch watch;
  options.after_stage = [&](FrameStage stage) {
    (stage == FrameStage::kTrack ? out.track_ms : out.seed_ms) = watch.ElapsedMs();
    watch = Stopwatch();
  };
  out.measurements = MeasureFrame(
      {frame.t_ns, std::move(detected.tags), false, frame.image, std::move(detected.doubled_ids)},
      options, &front_end_);
  return std::optional<MeasuredFrame>(std::move(out));
}

}  // namespace tagtwist::internal
