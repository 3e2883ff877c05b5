#include "bench/online.h"

#include <opencv2/calib3d.hpp>

#include "bench/cpu_clock.h"
#include "estimator/online/online.h"
#include "frontend/tags/find_tags.h"
#include "frontend/types/so3.h"

namespace tagtwist {
namespace {

void Judge(const BodyState& estimate, const BodyState& truth, bool has_velocity, MethodRun* run) {
  const StateVector e = Difference(estimate, truth);
  ++run->posed;
  run->squared_position_m2 += e.segment<3>(3).squaredNorm();
  if (has_velocity) run->squared_velocity_mps2 += e.segment<3>(6).squaredNorm();
}

}  // namespace

Result<PlainMethod> PlainMethod::Create(const Config& config, bool with_pose) {
  TagDetectorOptions options;
  options.upscale = 1;
  options.decimate = 1;
  auto detector = TagDetector::Create(config.map.family(), options);
  if (!detector) return detector.error();
  return PlainMethod(config, std::move(*detector), with_pose);
}

std::optional<Pose> PlainMethod::SolvePose(const std::vector<TagDetection>& tags) const {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const TagDetection& tag : tags) {
    if (config_.map.Find(tag.id) == nullptr) continue;
    for (size_t c = 0; c < 4; ++c) {
      const Eigen::Vector3d& p = config_.map.CornersInWorld(tag.id)[c];
      points.emplace_back(p.x(), p.y(), p.z());
      pixels.emplace_back(tag.corners[c].x(), tag.corners[c].y());
    }
  }
  const Camera& camera = config_.camera;
  const cv::Matx33d k(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  cv::Vec3d turn, place;
  if (points.empty() || !cv::solvePnP(points, pixels, k, {}, turn, place)) return std::nullopt;
  const Pose cam_from_world =
      MakePose(ExpSo3(Eigen::Vector3d(turn[0], turn[1], turn[2])), {place[0], place[1], place[2]});
  return Inverse(cam_from_world) * config_.cam_from_body;
}

void PlainMethod::Add(const SimulatedFrame& frame) {
  const CpuClock watch;
  const auto tags = detector_.Detect(frame.image);
  const auto pose = with_pose_ ? SolvePose(tags) : std::nullopt;
  run_.frame_ms.push_back(watch.ElapsedMs());
  run_.tags += tags.size();
  if (pose) Judge({*pose, {}}, frame.truth, /*has_velocity=*/false, &run_);
}

Result<OnlineMethod> OnlineMethod::Create(const Config& config, bool guided) {
  auto follower = TagFollower::Create(config.map, config.camera, config.cam_from_body,
                                      config.front_end.detector);
  if (!follower) return follower.error();
  auto detector = TagDetector::Create(config.map.family(), config.front_end.detector);
  if (!detector) return detector.error();
  auto refiner = CornerRefiner::Create(config.map, config.camera);
  if (!refiner) return refiner.error();
  return OnlineMethod(guided ? ForOnlineUse(config) : config, guided, std::move(*detector),
                      std::move(*refiner), std::move(*follower));
}

OnlineMethod::OnlineMethod(const Config& config, bool guided, TagDetector detector,
                           CornerRefiner refiner, TagFollower follower)
    : config_(config),
      guided_(guided),
      detector_(std::move(detector)),
      refiner_(std::move(refiner)),
      follower_(std::move(follower)),
      front_end_(config.camera, config.cam_from_body, config.map, config.front_end),
      window_(
          MakeEstimatorSetup(config.camera, config.cam_from_body, config.map, config.estimator)) {}

std::vector<TagDetection> OnlineMethod::FindTagsOf(const SimulatedFrame& frame) {
  if (guided_) return follower_.Find(frame.image, PredictPose(window_, frame.t_ns));
  return FindTags(frame.image, detector_, refiner_, config_.map, config_.camera,
                  config_.front_end.detector);
}

Status OnlineMethod::Add(const SimulatedFrame& frame) {
  FrameMeasurements measurement;
  measurement.t_ns = frame.t_ns;
  const CpuClock detect_watch;
  measurement.tags = FindTagsOf(frame);
  detect_ms_.push_back(detect_watch.ElapsedMs());
  const CpuClock track_watch;
  measurement.tracks = front_end_.Track(measurement.tags, frame.image);
  track_ms_.push_back(track_watch.ElapsedMs());
  const CpuClock seed_watch;
  measurement.closed_form =
      front_end_.ClosedFormOf(frame.t_ns, measurement.tags, measurement.tracks);
  seed_ms_.push_back(seed_watch.ElapsedMs());
  const CpuClock window_watch;
  const auto output = window_.Add(measurement);
  window_ms_.push_back(window_watch.ElapsedMs());
  if (!output) return output.error();
  run_.frame_ms.push_back(detect_ms_.back() + track_ms_.back() + seed_ms_.back() +
                          window_ms_.back());
  run_.tags += measurement.tags.size();
  if (output->current.status != FrameStatus::kNoFix) {
    Judge(output->current.state, frame.truth, /*has_velocity=*/true, &run_);
  }
  return Ok();
}

}  // namespace tagtwist
