#pragma once
#include <Eigen/Core>
#include <optional>

#include "frontend/types/body_state.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// A column of the course's `vicon`: x y z [m], roll pitch yaw [rad], v in W [m/s], omega in B
/// [rad/s]. The Euler order is Z-X-Y: world_from_body = Rz(yaw) Rx(roll) Ry(pitch).
using ViconColumn = Eigen::Matrix<double, 12, 1>;

Eigen::Quaterniond RotationFromZxy(const Eigen::Vector3d& roll_pitch_yaw);
/// The inverse, roll in [-pi/2, pi/2]; with roll at +-pi/2, where only the sum or difference of
/// the others is defined, pitch is 0.
Eigen::Vector3d ZxyFromRotation(const Eigen::Quaterniond& world_from_body);

TruthSample TruthFromVicon(int64_t t_ns, const ViconColumn& column);
/// nullopt where the sample has no twist: the format has no place for a pose alone.
std::optional<ViconColumn> ViconFromTruth(const TruthSample& sample);

}  // namespace tagtwist::internal
