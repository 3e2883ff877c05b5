#include "bench/online.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <utility>

#include "frontend/types/so3.h"

namespace tagtwist::internal {
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
  auto detector = TagDetector::Create(config.set_up.map.family(), options);
  if (!detector) return detector.error();
  return PlainMethod(config, std::move(*detector), with_pose);
}

std::optional<Pose> PlainMethod::SolvePose(const std::vector<TagDetection>& tags) const {
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const TagDetection& tag : tags) {
    if (config_.set_up.map.Find(tag.id) == nullptr) continue;
    for (size_t c = 0; c < 4; ++c) {
      const Eigen::Vector3d& p = config_.set_up.map.CornersInWorld(tag.id)[c];
      points.emplace_back(p.x(), p.y(), p.z());
      pixels.emplace_back(tag.corners[c].x(), tag.corners[c].y());
    }
  }
  const Camera& camera = config_.set_up.rig.front().camera;
  const cv::Matx33d k(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  cv::Vec3d turn, place;
  if (points.empty() || !cv::solvePnP(points, pixels, k, {}, turn, place)) return std::nullopt;
  const Pose cam_from_world =
      MakePose(ExpSo3(Eigen::Vector3d(turn[0], turn[1], turn[2])), {place[0], place[1], place[2]});
  return Inverse(cam_from_world) * config_.set_up.rig.front().cam_from_body;
}

void PlainMethod::Add(const SimulatedFrame& frame) {
  const CpuClock watch;
  const auto tags = detector_.Detect(frame.image);
  const auto pose = with_pose_ ? SolvePose(tags) : std::nullopt;
  run_.frame_ms.push_back(watch.ElapsedMs());
  run_.tags += tags.size();
  if (pose) Judge({*pose, {}}, frame.truth, /*has_velocity=*/false, &run_);
}

Result<PiecesMethod> PiecesMethod::Create(const Config& config) {
  auto refiner = CornerRefiner::Create(config.set_up.map, config.set_up.rig.front().camera);
  if (!refiner) return refiner.error();
  auto kept = std::make_unique<CornerRefiner>(std::move(*refiner));
  auto sweep = TagSweep::Create(config.set_up, config.front_end.detector, *kept);
  if (!sweep) return sweep.error();
  return PiecesMethod(config, std::move(kept), std::move(*sweep));
}

PiecesMethod::PiecesMethod(Config config, std::unique_ptr<CornerRefiner> refiner, TagSweep sweep)
    : config_(std::move(config)),
      refiner_(std::move(refiner)),
      sweep_(std::move(sweep)),
      front_end_(config_.set_up, config_.front_end) {}

void PiecesMethod::Add(const SimulatedFrame& frame) {
  piece_.push_back({frame.t_ns, frame.image});
  if (piece_.size() == TagSweep::PieceLength(config_.set_up.rig.front().camera)) Finish();
}

void PiecesMethod::Finish() {
  const CpuClock watch;
  const std::vector<SweptTags> found = sweep_.Find(piece_);
  for (size_t i = 0; i < piece_.size(); ++i) {
    front_end_.Process(piece_[i].t_ns, found[i].tags, piece_[i].gray);
    run_.tags += found[i].tags.size();
  }
  const double share_ms =
      watch.ElapsedMs() / static_cast<double>(std::max<size_t>(1, piece_.size()));
  run_.frame_ms.insert(run_.frame_ms.end(), piece_.size(), share_ms);
  piece_.clear();
}

void OnlineMethod::Stages::Add(FrameStage stage) {
  const double ms = since_last->ElapsedMs();
  if (stage == FrameStage::kDetect) detect_ms.push_back(ms);
  if (stage == FrameStage::kTrack) track_ms.push_back(ms);
  if (stage == FrameStage::kClosedForm) seed_ms.push_back(ms);
  if (stage == FrameStage::kSolve) window_ms.push_back(ms);
  since_last.emplace();
}

Result<OnlineMethod> OnlineMethod::Create(const Config& config, bool guided) {
  auto stages = std::make_unique<Stages>();
  OnlineOptions options;
  options.detection = guided ? DetectionMode::kGuided : DetectionMode::kFull;
  options.after_stage = [to = stages.get()](FrameStage stage) { to->Add(stage); };
  auto estimator = OnlineEstimator::Create(config, options);
  if (!estimator) return estimator.error();
  return OnlineMethod(std::move(*estimator), std::move(stages));
}

OnlineMethod::OnlineMethod(OnlineEstimator estimator, std::unique_ptr<Stages> stages)
    : stages_(std::move(stages)), estimator_(std::move(estimator)) {}

std::vector<std::pair<std::string, std::vector<double>>> OnlineMethod::stages() const {
  return {{"detection", stages_->detect_ms},
          {"tracks", stages_->track_ms},
          {"seed", stages_->seed_ms},
          {"window", stages_->window_ms}};
}

Status OnlineMethod::Add(const SimulatedFrame& frame) {
  stages_->since_last.emplace();
  const auto output = estimator_.AddImage(frame.t_ns, frame.image);
  if (!output) return output.error();
  double frame_ms = 0;
  for (const auto& [name, ms] : stages()) frame_ms += ms.back();
  run_.frame_ms.push_back(frame_ms);
  run_.tags += estimator_.measurements().tags.size();
  if (output->current.status != FrameStatus::kNoFix) {
    Judge(output->current.state, frame.truth, /*has_velocity=*/true, &run_);
  }
  return Ok();
}

}  // namespace tagtwist::internal
