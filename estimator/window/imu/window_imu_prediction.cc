// Of WindowImu: what its chain says of a time to come, and of tags that are seen then.
#include <algorithm>
#include <cmath>

#include "estimator/graph/reprojection.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/smoother.h"
#include "estimator/window/imu/window_imu.h"

namespace tagtwist::internal {
namespace {

bool IsAmong(int id, const std::vector<int>& ids) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

}  // namespace

// The tags that the window took, and those that lie where they may be expected.
std::vector<TagDetection> WindowImu::TagsNear(const GraphFrame& frame, const Block& covariance,
                                              const std::vector<TagDetection>& tags,
                                              const std::vector<int>& used) const {
  constexpr double kNearPx = 5, kSigmas = 4;
  const double turn = std::sqrt(covariance.topLeftCorner<3, 3>().trace()),
               way = std::sqrt(covariance.block<3, 3>(3, 3).trace());
  std::vector<TagDetection> out;
  GraphFrame one = frame;
  for (const TagDetection& tag : tags) {
    const MountedCamera camera = setup_.CameraOf(tag.camera);
    const Pose cam_from_map = camera.CamFromMap(frame.state.world_from_body);
    const double depth_m = (cam_from_map * setup_.map.CornersInWorld(tag.id).front()).norm();
    const double near_px =
        kNearPx + kSigmas * camera.camera.fx * (turn + way / std::max(0.05, depth_m));
    one.tags = {tag};
    const std::vector<double> errors = ReprojectionErrors(setup_, one);
    const bool near =
        errors.size() == 4 && *std::max_element(errors.begin(), errors.end()) < near_px;
    if (near || IsAmong(tag.id, used)) out.push_back(tag);
  }
  return out;
}

// Of a state that says nothing any more.
bool WindowImu::IsUseless() const {
  constexpr double kMostM = 0.5, kMostRad = 0.3;
  const int newest = static_cast<int>(frames_.size()) - 1;
  const Block& p = covariance_.At(newest, newest);
  const double turn = p.topLeftCorner<3, 3>().trace(), way = p.block<3, 3>(3, 3).trace();
  return !(turn < kMostRad * kMostRad && way < kMostM * kMostM);
}

// Most of the newest frame's tags lie elsewhere, though they were solved with.
bool WindowImu::Contradicts(const NoiseModel& noise) const {
  const GraphFrame& newest = frames_.back();
  const auto agrees = [&](const TagDetection& tag) {
    return AgreesWith(setup_, noise, newest.state, tag);
  };
  const auto n = std::count_if(newest.tags.begin(), newest.tags.end(), agrees);
  return 2 * static_cast<size_t>(n) < newest.tags.size();
}

std::optional<StateAndCovariance> WindowImu::PredictAt(int64_t t_ns) const {
  if (frames_.empty()) return std::nullopt;
  const GraphFrame& last = frames_.back();
  const auto motion = Preintegrate(in_body_, last.t_ns, t_ns, BiasOf(last.acceleration),
                                   NoiseOf(options_, model_->scale), kLongestImuStepS);
  if (!motion) return std::nullopt;
  const int newest = static_cast<int>(frames_.size()) - 1;
  const Eigen::Vector3d rate =
      RateAt(in_body_, t_ns, BiasOf(last.acceleration)).value_or(last.state.twist.omega_body);
  StateAndCovariance out{CarryOn(last.state, *motion, model_->calibration, rate),
                         BodyCovariance(covariance_, newest)};
  // Of the pose: what the velocity carries on, and the IMU's own noise.
  StateCovariance onward = StateCovariance::Identity();
  onward.block<3, 3>(3, 6).diagonal().setConstant(motion->dt_s);
  out.covariance = (onward * out.covariance * onward.transpose()).eval();
  const Eigen::Matrix3d rotation = last.state.world_from_body.rotation().toRotationMatrix();
  out.covariance.block<3, 3>(0, 0) += motion->covariance.block<3, 3>(0, 0);
  out.covariance.block<3, 3>(3, 3) +=
      rotation * motion->covariance.block<3, 3>(6, 6) * rotation.transpose();
  out.covariance.block<3, 3>(6, 6) +=
      rotation * motion->covariance.block<3, 3>(3, 3) * rotation.transpose();
  return out;
}

}  // namespace tagtwist::internal
