#include "estimator/online/online_estimator.h"

#include <string>
#include <utility>

#include "estimator/online/config.h"
#include "estimator/online/image_size.h"
#include "estimator/online/online.h"
#include "frontend/tags/find_tags.h"

namespace tagtwist {

Result<OnlineEstimator> OnlineEstimator::Create(const Config& config) {
  const TagDetectorOptions& options = config.front_end.detector;
  if (!options.refine_pattern) {
    auto detector = TagDetector::Create(config.map.family(), options);
    if (!detector) return detector.error();
    return OnlineEstimator(config, std::nullopt, std::move(*detector));
  }
  auto follower = TagFollower::Create(config.map, config.camera, config.cam_from_body, options);
  if (!follower) return follower.error();
  return OnlineEstimator(ForOnlineUse(config), std::move(*follower), std::nullopt);
}

OnlineEstimator::OnlineEstimator(const Config& config, std::optional<TagFollower> follower,
                                 std::optional<TagDetector> detector)
    : config_(config),
      follower_(std::move(follower)),
      detector_(std::move(detector)),
      front_end_(config.camera, config.cam_from_body, config.map, config.front_end),
      window_(SetupOf(config)) {
  if (config.line_time_s != 0) undo_.emplace(SetupOf(config), config.line_time_s);
}

Status OnlineEstimator::Check(int64_t t_ns, const cv::Mat& gray) const {
  if (last_ns_ && t_ns <= *last_ns_) {
    return Error{"stamps must grow: " + std::to_string(t_ns) + " ns follows " +
                 std::to_string(*last_ns_) + " ns"};
  }
  const auto problem = ImageSizeProblem(gray, config_.camera);
  return problem ? Status(Error{*problem}) : Ok();
}

Result<WindowOutput> OnlineEstimator::AddImage(int64_t t_ns, const cv::Mat& gray) {
  if (!follower_) return AddTags(t_ns, detector_->Detect(gray), gray);
  if (const auto fine = Check(t_ns, gray); !fine) return fine.error();
  return Add(t_ns, follower_->Find(gray, PredictPose(window_, t_ns)), gray);
}

Result<WindowOutput> OnlineEstimator::AddTags(int64_t t_ns, const std::vector<TagDetection>& tags,
                                              const cv::Mat& gray) {
  if (const auto fine = Check(t_ns, gray); !fine) return fine.error();
  const double border_px = config_.front_end.detector.border_px;
  return Add(t_ns, FilterTags(tags, config_.map, config_.camera, border_px), gray);
}

Result<WindowOutput> OnlineEstimator::Add(int64_t t_ns, const std::vector<TagDetection>& tags,
                                          const cv::Mat& gray) {
  last_ns_ = t_ns;
  FrameMeasurements measurements = front_end_.Process(t_ns, tags, gray);
  if (undo_) {
    auto undone = undo_->AsOfStamp(std::move(measurements));
    if (!undone) return undone.error();
    measurements = std::move(*undone);
  }
  return window_.Add(measurements);
}

}  // namespace tagtwist
