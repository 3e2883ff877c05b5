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
  if (config.set_up.rig.mounted_on != MountedOn::kBody) return false;
  return config.front_end.detector.refine_pattern;
}

}  // namespace

struct OnlineEstimator::Impl {
  Impl(const Config& with_config, const OnlineOptions& with_options)
      : config(with_config), options(with_options), window(config.set_up, config.estimator) {
    for (size_t i = 0; i < config.set_up.rig.cameras.size(); ++i) {
      front_ends.emplace_back(SetUpOfCamera(config.set_up, i), config.front_end);
    }
    if (options.use_imu) window.Use(config.imu);
  }

  Status MakeDetectors(bool guided);
  Status Check(int64_t t_ns, const std::vector<CameraImage>& images) const;
  std::vector<DetectedFrame> Detect(int64_t t_ns, const std::vector<CameraImage>& images);
  void Detect(const CameraImage& seen, const std::optional<PosePrediction>& prediction,
              DetectedFrame* out);
  FrameMeasurements Measure(std::vector<DetectedFrame> of_cameras);
  bool is_guided() const { return !followers.empty(); }
  void Tell(FrameStage stage) const {
    if (options.after_stage) options.after_stage(stage);
  }
  Result<WindowOutput> Solve(FrameMeasurements measurements);

  Config config;
  OnlineOptions options;
  std::vector<TagFollower> followers;  // of each camera: guided,
  std::vector<TagFinder> finders;      // or not
  std::vector<FrontEnd> front_ends;    // of each
  SlidingWindow window;
  FrameMeasurements last;
  bool has_frame = false;
};

Status OnlineEstimator::Impl::MakeDetectors(bool guided) {
  const TagDetectorOptions& look = config.front_end.detector;
  for (size_t i = 0; i < config.set_up.rig.cameras.size(); ++i) {
    const SetUp of_camera = SetUpOfCamera(config.set_up, i);
    if (guided) {
      auto follower = TagFollower::Create(of_camera, look);
      if (!follower) return follower.error();
      followers.push_back(std::move(*follower));
    } else {
      auto finder = TagFinder::Create(of_camera, look);
      if (!finder) return finder.error();
      finders.push_back(std::move(*finder));
    }
  }
  return Ok();
}

Result<OnlineEstimator> OnlineEstimator::Create(const Config& config,
                                                const OnlineOptions& options) {
  const bool guided = IsGuided(config, options.detection);
  if (guided && config.set_up.rig.mounted_on != MountedOn::kBody) {
    return Error{
        "guided detection is of cameras on the body, and those of the configuration stand: "
        "expected full detection"};
  }
  auto impl = std::make_unique<Impl>(guided ? ForOnlineUse(config) : config, options);
  if (const Status made = impl->MakeDetectors(guided); !made) return made.error();
  return OnlineEstimator(std::move(impl));
}

OnlineEstimator::OnlineEstimator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OnlineEstimator::OnlineEstimator(OnlineEstimator&&) noexcept = default;
OnlineEstimator& OnlineEstimator::operator=(OnlineEstimator&&) noexcept = default;
OnlineEstimator::~OnlineEstimator() = default;

bool OnlineEstimator::is_guided() const { return !impl_->followers.empty(); }

Status OnlineEstimator::Impl::Check(int64_t t_ns, const std::vector<CameraImage>& images) const {
  if (has_frame && t_ns <= last.t_ns) {
    return Error{"stamps must grow: " + std::to_string(t_ns) + " ns follows " +
                 std::to_string(last.t_ns) + " ns"};
  }
  const std::vector<RigCamera>& cameras = config.set_up.rig.cameras;
  int next = 0;
  for (const CameraImage& seen : images) {
    if (seen.camera < next || seen.camera >= static_cast<int>(cameras.size())) {
      return Error{"cameras " + std::to_string(next) + " to " + std::to_string(cameras.size() - 1) +
                   " may follow, got camera " + std::to_string(seen.camera)};
    }
    next = seen.camera + 1;
    const Camera& camera = cameras[static_cast<size_t>(seen.camera)].camera;
    if (const auto problem = ImageSizeProblem(seen.image, camera)) return Error{*problem};
  }
  return Ok();
}

std::vector<DetectedFrame> OnlineEstimator::Impl::Detect(int64_t t_ns,
                                                         const std::vector<CameraImage>& images) {
  const Span span(options.spans, "detect");
  const auto prediction = is_guided() ? PredictPose(window, t_ns) : std::nullopt;
  std::vector<DetectedFrame> out(images.size());
  options.for_ranges(images.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      out[i].t_ns = t_ns;
      Detect(images[i], prediction, &out[i]);
    }
  });
  Tell(FrameStage::kDetect);
  return out;
}

void OnlineEstimator::Impl::Detect(const CameraImage& seen,
                                   const std::optional<PosePrediction>& prediction,
                                   DetectedFrame* out) {
  out->image = seen.image;
  out->camera = seen.camera;
  const auto index = static_cast<size_t>(seen.camera);
  if (is_guided()) {
    TagFollower& follower = followers[index];
    out->tags = follower.Find(seen.image, prediction, options.detection_time_up);
    out->cut_short = follower.was_cut_short();
    out->doubled_ids = follower.doubled_ids();
  } else {
    out->tags = finders[index].Find(seen.image, &out->doubled_ids);
  }
  for (TagDetection& tag : out->tags) tag.camera = seen.camera;
}

FrameMeasurements OnlineEstimator::Impl::Measure(std::vector<DetectedFrame> of_cameras) {
  std::optional<FrameMeasurements> out;
  size_t n_tags = 0;
  for (const DetectedFrame& detected : of_cameras) n_tags += detected.tags.size();
  for (DetectedFrame& detected : of_cameras) {
    detected.besides.tags_elsewhere = n_tags - detected.tags.size();
    FrameMeasurements measured = MeasureFrame(std::move(detected), options, &front_ends);
    if (out) {
      AddCamera(measured, &*out);
    } else {
      out = std::move(measured);
    }
  }
  return std::move(*out);
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
  return AddImages(t_ns, {{0, gray}});
}

Result<WindowOutput> OnlineEstimator::AddImages(int64_t t_ns,
                                                const std::vector<CameraImage>& images) {
  if (images.empty()) return Error{"a frame has an image, or an empty one, of a camera at least"};
  if (const auto fine = impl_->Check(t_ns, images); !fine) return fine.error();
  return impl_->Solve(impl_->Measure(impl_->Detect(t_ns, images)));
}

Result<WindowOutput> OnlineEstimator::AddTags(int64_t t_ns, const std::vector<TagDetection>& tags) {
  return AddTags(t_ns, tags, cv::Mat());
}

Result<WindowOutput> OnlineEstimator::AddTags(int64_t t_ns, const std::vector<TagDetection>& tags,
                                              const cv::Mat& gray) {
  if (const auto fine = impl_->Check(t_ns, {{0, gray}}); !fine) return fine.error();
  const Config& config = impl_->config;
  std::vector<DetectedFrame> of_cameras;
  for (size_t i = 0; i < config.set_up.rig.cameras.size(); ++i) {
    const auto own = TagsOfCamera(tags, static_cast<int>(i));
    if (own.empty() && i > 0) continue;
    DetectedFrame detected;
    detected.t_ns = t_ns;
    detected.camera = static_cast<int>(i);
    if (i == 0) detected.image = gray;
    detected.tags = FilterTags(own, config.set_up.map, config.set_up.rig.cameras[i].camera,
                               config.front_end.detector.border_px);
    detected.doubled_ids = DoubledIds(own, config.set_up.map);
    of_cameras.push_back(std::move(detected));
  }
  impl_->Tell(FrameStage::kDetect);
  return impl_->Solve(impl_->Measure(std::move(of_cameras)));
}

Result<WindowOutput> OnlineEstimator::AddMeasurements(FrameMeasurements measurements) {
  if (const auto fine = impl_->Check(measurements.t_ns, {}); !fine) return fine.error();
  return impl_->Solve(std::move(measurements));
}

const FrameMeasurements& OnlineEstimator::measurements() const { return impl_->last; }

void OnlineEstimator::AddImu(const std::vector<ImuSample>& samples) {
  impl_->window.AddImu(samples);
}

std::vector<FrameEstimate> OnlineEstimator::Finish() { return impl_->window.Finish(); }

const SlidingWindow& OnlineEstimator::window() const { return impl_->window; }

}  // namespace tagtwist
