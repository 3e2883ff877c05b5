#include "residuals/truth_residual.h"

#include "frontend/types/so3.h"

namespace tagtwist::internal {

TruthResidual EvaluateTruth(const Pose& truth, const Twist& rate, const Pose& truth_from_world,
                            const Pose& world_from_cam, const Pose& cam_from_body) {
  const Pose world_from_body = world_from_cam * cam_from_body;
  const Pose predicted = truth_from_world * world_from_body;
  const Eigen::Matrix3d a = truth_from_world.rotation().toRotationMatrix();
  const Eigen::Matrix3d c = world_from_cam.rotation().toRotationMatrix();
  const Eigen::Matrix3d m = cam_from_body.rotation().toRotationMatrix();
  TruthResidual out;
  out.residual = Difference(predicted, truth);
  const Eigen::Vector3d log = out.residual.head<3>();
  const Eigen::Matrix3d log_by_right = RightJacobianInverseSo3(log);
  out.by_cam << log_by_right * m.transpose(), Eigen::Matrix3d::Zero(),
      -a * c * Hat(cam_from_body.translation()), a;
  out.by_world << log_by_right * (c * m).transpose(), Eigen::Matrix3d::Zero(),
      -a * Hat(world_from_body.translation()), Eigen::Matrix3d::Identity();
  out.by_mount << log_by_right, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), a * c;
  out.by_offset << -RightJacobianInverseSo3(-log) * rate.omega_body, -rate.v_world;
  return out;
}

}  // namespace tagtwist::internal
