#include "estimator/jobs/measurement_stream.h"

#include <algorithm>
#include <utility>

#include "estimator/live/stopwatch.h"
#include "estimator/online/image_size.h"
#include "estimator/online/online.h"
#include "frontend/tags/find_tags.h"

namespace tagtwist {
Result<MeasurementStream> MeasurementStream::Create(DataSource* source, const Config& config,
                                                    bool use_detections, int threads) {
  std::vector<TagDetector> detectors;
  for (int i = 0; i < std::max(1, threads); ++i) {
    auto detector = TagDetector::Create(config.map.family(), config.front_end.detector);
    if (!detector) return detector.error();
    detectors.push_back(std::move(*detector));
  }
  auto refiner = CornerRefiner::Create(config.map, config.camera);
  if (!refiner) return refiner.error();
  return MeasurementStream(source,
                           std::make_unique<const Shared>(Shared{config, std::move(*refiner)}),
                           use_detections, std::move(detectors));
}

Result<MeasurementStream> MeasurementStream::CreateGuided(DataSource* source, const Config& config,
                                                          PosePredictor predict) {
  auto out = Create(source, ForOnlineUse(config), /*use_detections=*/false, /*threads=*/1);
  if (!out) return out;
  auto follower = TagFollower::Create(config.map, config.camera, config.cam_from_body,
                                      config.front_end.detector);
  if (!follower) return follower.error();
  out->follower_ = std::move(*follower);
  out->predict_ = std::move(predict);
  return out;
}

MeasurementStream::MeasurementStream(DataSource* source, std::unique_ptr<const Shared> shared,
                                     bool use_detections, std::vector<TagDetector> detectors)
    : source_(source),
      shared_(std::move(shared)),
      use_detections_(use_detections),
      detectors_(std::move(detectors)),
      front_end_(shared_->config.camera, shared_->config.cam_from_body, shared_->config.map,
                 shared_->config.front_end) {}

MeasurementStream::Detected MeasurementStream::Detect(Frame frame, const TagDetector& detector,
                                                      const Shared& shared, bool use_detections) {
  const Stopwatch watch;
  const Config& config = shared.config;
  const TagDetectorOptions& options = config.front_end.detector;
  Detected out;
  out.tags =
      use_detections
          ? FilterTags(frame.detections, config.map, config.camera, options.border_px)
          : FindTags(frame.image, detector, shared.refiner, config.map, config.camera, options);
  out.frame = std::move(frame);
  out.detect_ms = watch.ElapsedMs();
  return out;
}

Result<std::optional<Frame>> MeasurementStream::NextFrame() {
  auto frame = source_->Next();
  if (!frame || !*frame) return frame;
  if (const auto problem = ImageSizeProblem((*frame)->image, shared_->config.camera)) {
    return Error{(*frame)->name + ": " + *problem};
  }
  return frame;
}

Status MeasurementStream::FillQueue() {
  // One frame under way a detector; with a single thread each is measured when it is asked for.
  const auto policy = detectors_.size() > 1 ? std::launch::async : std::launch::deferred;
  while (!at_end_ && queue_.size() < detectors_.size()) {
    auto frame = NextFrame();
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

Result<std::optional<MeasurementStream::Detected>> MeasurementStream::NextDetected() {
  if (const auto filled = FillQueue(); !filled) return filled.error();
  if (queue_.empty()) return std::optional<Detected>();
  if (deadline_ != nullptr) deadline_->Start();
  std::optional<Detected> out = queue_.front().get();
  queue_.pop_front();
  return out;
}

Result<std::optional<MeasurementStream::Detected>> MeasurementStream::NextGuided() {
  auto frame = NextFrame();
  if (!frame) return frame.error();
  if (!*frame) return std::optional<Detected>();
  if (deadline_ != nullptr) deadline_->Start();
  const Stopwatch watch;
  Detected out;
  out.tags = follower_->Find((*frame)->image, predict_((*frame)->t_ns),
                             deadline_ != nullptr ? deadline_->ForDetection() : TimeUp());
  out.cut_short = follower_->was_cut_short();
  out.frame = std::move(**frame);
  out.detect_ms = watch.ElapsedMs();
  return std::optional<Detected>(std::move(out));
}

Result<std::optional<MeasuredFrame>> MeasurementStream::Next() {
  const auto next = follower_ ? NextGuided() : NextDetected();
  if (!next) return next.error();
  if (!*next) return std::optional<MeasuredFrame>();
  const Detected& detected = **next;

  MeasuredFrame out;
  out.detect_ms = detected.detect_ms;
  const Frame& frame = detected.frame;
  if (!frame.image_problem.empty()) out.image_problem = frame.name + ": " + frame.image_problem;
  const Stopwatch track_watch;
  out.measurements.t_ns = frame.t_ns;
  out.measurements.tags = detected.tags;
  // Tracks end where there is no time for them.
  const bool hurry = deadline_ != nullptr && IsUp(deadline_->ForDetection());
  out.measurements.tracks = front_end_.Track(detected.tags, hurry ? cv::Mat() : frame.image);
  out.measurements.cut_short = detected.cut_short || (hurry && !frame.image.empty());
  out.track_ms = track_watch.ElapsedMs();
  const Stopwatch seed_watch;
  out.measurements.closed_form =
      front_end_.ClosedFormOf(frame.t_ns, detected.tags, out.measurements.tracks);
  out.seed_ms = seed_watch.ElapsedMs();
  return std::optional<MeasuredFrame>(std::move(out));
}

}  // namespace tagtwist
