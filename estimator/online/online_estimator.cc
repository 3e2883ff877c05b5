#include "estimator/online/online_estimator.h"

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <utility>

#include "estimator/online/guidance.h"
#include "estimator/online/image_size.h"
#include "estimator/online/measure_frame.h"
#include "estimator/rig/rig_tags.h"
#include "frontend/base/spans.h"
#include "frontend/front_end.h"
#include "frontend/tags/filter_tags.h"
#include "frontend/tags/tag_finder.h"
#include "frontend/tags/tag_follower.h"

namespace tagtwist {

using namespace internal;
namespace {

bool IsGuided(const Config& config, DetectionMode mode) {
  if (mode != DetectionMode::kAuto) return mode == DetectionMode::kGuided;
  if (!config.set_up.rig.IsOneOnTheBody()) return false;
  return config.front_end.detector.refine_pattern;
}

}  // namespace

struct OnlineEstimator::Impl {
  Impl(const Config& with_config, const OnlineOptions& with_options)
      : config(with_config),
        options(with_options),
        front_end(config.set_up, config.front_end),
        window(config.set_up, config.estimator) {
    if (options.use_imu) window.Use(config.imu);
  }

  Status Check(int64_t t_ns, const cv::Mat& gray) const;
  DetectedFrame Detect(int64_t t_ns, const cv::Mat& gray);
  void Tell(FrameStage stage) const {
    if (options.after_stage) options.after_stage(stage);
  }
  Result<WindowOutput> Solve(FrameMeasurements measurements);

  Config config;
  OnlineOptions options;
  std::optional<TagFollower> follower;  // guided,
  std::optional<TagFinder> finder;      // or not
  FrontEnd front_end;
  SlidingWindow window;
  FrameMeasurements last;
  bool has_frame = false;
};

Result<OnlineEstimator> OnlineEstimator::Create(const Config& config,
                                                const OnlineOptions& options) {
  if (!config.set_up.rig.IsOneOnTheBody() && IsGuided(config, options.detection)) {
    return Error{
        "guided detection follows one camera on the body, and the configuration has others: "
        "expected full detection"};
  }
  if (!IsGuided(config, options.detection)) {
    auto finder = TagFinder::Create(config.set_up, config.front_end.detector);
    if (!finder) return finder.error();
    auto impl = std::make_unique<Impl>(config, options);
    impl->finder.emplace(std::move(*finder));
    return OnlineEstimator(std::move(impl));
  }
  auto follower = TagFollower::Create(config.set_up, config.front_end.detector);
  if (!follower) return follower.error();
  auto impl = std::make_unique<Impl>(ForOnlineUse(config), options);
  impl->follower.emplace(std::move(*follower));
  return OnlineEstimator(std::move(impl));
}

OnlineEstimator::OnlineEstimator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OnlineEstimator::OnlineEstimator(OnlineEstimator&&) noexcept = default;
OnlineEstimator& OnlineEstimator::operator=(OnlineEstimator&&) noexcept = default;
OnlineEstimator::~OnlineEstimator() = default;

bool OnlineEstimator::is_guided() const { return impl_->follower.has_value(); }

Status OnlineEstimator::Impl::Check(int64_t t_ns, const cv::Mat& gray) const {
  if (has_frame && t_ns <= last.t_ns) {
    return Error{"stamps must grow: " + std::to_string(t_ns) + " ns follows " +
                 std::to_string(last.t_ns) + " ns"};
  }
  if (!gray.empty() && !config.set_up.rig.IsOneOnTheBody()) {
    return Error{"of cameras but one on the body corners are taken, not images"};
  }
  const auto problem = ImageSizeProblem(gray, config.set_up.rig.front().camera);
  return problem ? Status(Error{*problem}) : Ok();
}

DetectedFrame OnlineEstimator::Impl::Detect(int64_t t_ns, const cv::Mat& gray) {
  DetectedFrame out;
  out.t_ns = t_ns;
  out.image = gray;
  const Span span(options.spans, "detect");
  if (follower) {
    out.tags = follower->Find(gray, PredictPose(window, t_ns), options.detection_time_up);
    out.cut_short = follower->was_cut_short();
    out.doubled_ids = follower->doubled_ids();
  } else {
    out.tags = finder->Find(gray, &out.doubled_ids);
  }
  Tell(FrameStage::kDetect);
  return out;
}

Result<WindowOutput> OnlineEstimator::Impl::Solve(FrameMeasurements measurements) {
  last = std::move(measurements);
  has_frame = true;
  const Span span(options.spans, "solve");
  auto out = window.Add(last, options.solve_time_up);
  Tell(FrameStage::kSolve);
  return out;
}

Result<WindowOutput> OnlineEstimator::AddImage(int64_t t_ns, const cv::Mat& gray) {
  if (const auto fine = impl_->Check(t_ns, gray); !fine) return fine.error();
  DetectedFrame detected = impl_->Detect(t_ns, gray);
  return impl_->Solve(MeasureFrame(std::move(detected), impl_->options, &impl_->front_end));
}

Result<WindowOutput> OnlineEstimator::AddTags(int64_t t_ns, const std::vector<TagDetection>& tags) {
  return AddTags(t_ns, tags, cv::Mat());
}

Result<WindowOutput> OnlineEstimator::AddTags(int64_t t_ns, const std::vector<TagDetection>& tags,
                                              const cv::Mat& gray) {
  if (const auto fine = impl_->Check(t_ns, gray); !fine) return fine.error();
  const Config& config = impl_->config;
  DetectedFrame detected;
  detected.t_ns = t_ns;
  detected.image = gray;
  for (size_t i = 0; i < config.set_up.rig.cameras.size(); ++i) {
    const auto own = TagsOfCamera(tags, static_cast<int>(i));
    const auto kept = FilterTags(own, config.set_up.map, config.set_up.rig.cameras[i].camera,
                                 config.front_end.detector.border_px);
    const auto doubled = DoubledIds(own, config.set_up.map);
    detected.tags.insert(detected.tags.end(), kept.begin(), kept.end());
    detected.doubled_ids.insert(detected.doubled_ids.end(), doubled.begin(), doubled.end());
  }
  impl_->Tell(FrameStage::kDetect);
  return impl_->Solve(MeasureFrame(std::move(detected), impl_->options, &impl_->front_end));
}

Result<WindowOutput> OnlineEstimator::AddMeasurements(FrameMeasurements measurements) {
  if (const auto fine = impl_->Check(measurements.t_ns, cv::Mat()); !fine) return fine.error();
  return impl_->Solve(std::move(measurements));
}

const FrameMeasurements& OnlineEstimator::measurements() const { return impl_->last; }

void OnlineEstimator::AddImu(const std::vector<ImuSample>& samples) {
  impl_->window.AddImu(samples);
}

std::vector<FrameEstimate> OnlineEstimator::Finish() { return impl_->window.Finish(); }

const SlidingWindow& OnlineEstimator::window() const { return impl_->window; }

}  // namespace tagtwist
