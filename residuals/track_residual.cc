#include "residuals/track_residual.h"

#include "frontend/types/so3.h"
#include "residuals/pose_manifold.h"

namespace tagtwist::internal {

TrackResidual::TrackResidual(const Eigen::Vector2d& pixel, double sigma_px,
                             const Pose& world_from_plane, const Camera& camera,
                             const Pose& cam_from_body)
    : pixel_(pixel),
      inverse_sigma_(1.0 / sigma_px),
      d_world_d_point_(world_from_plane.rotation().toRotationMatrix().leftCols<2>()),
      plane_in_world_(world_from_plane.translation()),
      camera_(camera),
      cam_from_body_rotation_(cam_from_body.rotation().toRotationMatrix()),
      body_in_cam_(cam_from_body.translation()) {}

bool TrackResidual::Evaluate(double const* const* parameters, double* residuals,
                             double** jacobians) const {
  const Eigen::Matrix3d body_from_world_rotation =
      Eigen::Map<const Eigen::Quaterniond>(parameters[0]).toRotationMatrix().transpose();
  const Eigen::Map<const Eigen::Vector3d> body_in_world(parameters[0] + 4);
  const Eigen::Map<const Eigen::Vector2d> point_on_plane(parameters[1]);

  const Eigen::Vector3d point_in_world = d_world_d_point_ * point_on_plane + plane_in_world_;
  const Eigen::Vector3d point_in_body = body_from_world_rotation * (point_in_world - body_in_world);
  Eigen::Vector2d predicted;
  Eigen::Matrix<double, 2, 3> d_pixel_d_cam;
  if (!camera_.Project(cam_from_body_rotation_ * point_in_body + body_in_cam_, &predicted,
                       &d_pixel_d_cam)) {
    return false;
  }
  Eigen::Map<Eigen::Vector2d>(residuals, 2) = inverse_sigma_ * (predicted - pixel_);
  if (jacobians == nullptr) return true;

  const Eigen::Matrix<double, 2, 3> d_residual_d_body =
      inverse_sigma_ * d_pixel_d_cam * cam_from_body_rotation_;
  if (jacobians[0] != nullptr) {
    Eigen::Matrix<double, 3, 6> d_body_d_tangent;  // tangent = [theta, rho], see pose.h
    d_body_d_tangent << Hat(point_in_body), -body_from_world_rotation;
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift;  // tangent -> ambient
    PoseManifold().MinusJacobian(parameters[0], lift.data());
    Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>>(jacobians[0]).noalias() =
        d_residual_d_body * d_body_d_tangent * lift;
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 2, 2, Eigen::RowMajor>>(jacobians[1]).noalias() =
        d_residual_d_body * body_from_world_rotation * d_world_d_point_;
  }
  return true;
}

}  // namespace tagtwist::internal
