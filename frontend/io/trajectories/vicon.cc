#include "frontend/io/trajectories/vicon.h"

#include <cmath>

namespace tagtwist::internal {

Eigen::Quaterniond RotationFromZxy(const Eigen::Vector3d& roll_pitch_yaw) {
  return Eigen::AngleAxisd(roll_pitch_yaw.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(roll_pitch_yaw.x(), Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(roll_pitch_yaw.y(), Eigen::Vector3d::UnitY());
}

Eigen::Vector3d ZxyFromRotation(const Eigen::Quaterniond& world_from_body) {
  const Eigen::Matrix3d r = world_from_body.toRotationMatrix();
  // Row 2 is (-cos(roll) sin(pitch), sin(roll), cos(roll) cos(pitch)),
  // column 1 is (-sin(yaw) cos(roll), cos(yaw) cos(roll), sin(roll)).
  const double cos_roll = std::hypot(r(2, 0), r(2, 2));
  const double roll = std::atan2(r(2, 1), cos_roll);
  if (cos_roll < 1e-12) return {roll, 0, std::atan2(r(1, 0), r(0, 0))};
  return {roll, std::atan2(-r(2, 0), r(2, 2)), std::atan2(-r(0, 1), r(1, 1))};
}

TruthSample TruthFromVicon(int64_t t_ns, const ViconColumn& column) {
  TruthSample sample;
  sample.t_ns = t_ns;
  sample.world_from_body = MakePose(RotationFromZxy(column.segment<3>(3)), column.head<3>());
  sample.twist = Twist{column.segment<3>(6), column.tail<3>()};
  return sample;
}

std::optional<ViconColumn> ViconFromTruth(const TruthSample& sample) {
  if (!sample.twist) return std::nullopt;
  ViconColumn column;
  column << sample.world_from_body.translation(),
      ZxyFromRotation(sample.world_from_body.rotation()), sample.twist->v_world,
      sample.twist->omega_body;
  return column;
}

}  // namespace tagtwist::internal
