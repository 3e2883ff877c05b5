#include "residuals/tag_reprojection_residual.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "frontend/types/so3.h"
#include "residuals/pose_manifold.h"

namespace tagtwist {

TagReprojectionResidual::TagReprojectionResidual(const TagObservation& observation,
                                                 const Camera& camera, const Pose& cam_from_body)
    : corners_in_world_(observation.corners_in_world),
      pixels_(observation.pixels),
      camera_(camera),
      cam_from_body_rotation_(cam_from_body.rotation().toRotationMatrix()),
      body_in_cam_(cam_from_body.translation()) {
  whitener_ = observation.covariance.inverse().llt().matrixU();
}

bool TagReprojectionResidual::Evaluate(double const* const* parameters, double* residuals,
                                       double** jacobians) const {
  const Eigen::Matrix3d body_from_world_rotation =
      Eigen::Map<const Eigen::Quaterniond>(parameters[0]).toRotationMatrix().transpose();
  const Eigen::Map<const Eigen::Vector3d> body_in_world(parameters[0] + 4);
  const bool wants_jacobian = jacobians != nullptr && jacobians[0] != nullptr;

  Eigen::Matrix<double, 8, 1> error;
  Eigen::Matrix<double, 8, 6> d_error_d_tangent;
  for (int i = 0; i < 4; ++i) {
    const auto c = static_cast<size_t>(i);
    const Eigen::Vector3d corner_in_body =
        body_from_world_rotation * (corners_in_world_[c] - body_in_world);
    const Eigen::Vector3d corner_in_cam = cam_from_body_rotation_ * corner_in_body + body_in_cam_;
    Eigen::Vector2d predicted;
    Eigen::Matrix<double, 2, 3> d_pixel_d_cam;
    if (!camera_.Project(corner_in_cam, &predicted, wants_jacobian ? &d_pixel_d_cam : nullptr)) {
      return false;
    }
    error.segment<2>(2 * i) = predicted - pixels_[c];
    if (!wants_jacobian) continue;
    Eigen::Matrix<double, 3, 6> d_body_d_tangent;  // tangent = [theta, rho], see pose.h
    d_body_d_tangent << Hat(corner_in_body), -body_from_world_rotation;
    d_error_d_tangent.middleRows<2>(2 * i) =
        d_pixel_d_cam * cam_from_body_rotation_ * d_body_d_tangent;
  }
  Eigen::Map<Eigen::Matrix<double, 8, 1>>(residuals).noalias() = whitener_ * error;
  if (!wants_jacobian) return true;

  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift;  // tangent -> ambient
  PoseManifold().MinusJacobian(parameters[0], lift.data());
  Eigen::Map<Eigen::Matrix<double, 8, 7, Eigen::RowMajor>>(jacobians[0]).noalias() =
      whitener_ * (d_error_d_tangent * lift);
  return true;
}

}  // namespace tagtwist
