#include "residuals/tag_reprojection_residual.h"

#include "frontend/types/so3.h"
#include "residuals/corner_whitener.h"
#include "residuals/pose_manifold.h"

namespace tagtwist::internal {

TagReprojection::TagReprojection(const TagObservation& observation, const Camera& camera,
                                 const Pose& cam_from_body, MountedOn mounted_on)
    : corners_in_world_(observation.corners_in_world),
      pixels_(observation.pixels),
      camera_(camera),
      mounted_on_(mounted_on),
      cam_from_body_rotation_(cam_from_body.rotation().toRotationMatrix()),
      body_in_cam_(cam_from_body.translation()) {
  const Eigen::Matrix<double, 8, 8> whitener = CornerWhitener(observation.covariance);
  diagonal_ = whitener.diagonal();
  is_in_pixels_ = whitener.isIdentity(0);
  if (is_in_pixels_ || observation.covariance.isDiagonal(0)) return;
  whitener_ = std::make_unique<const Eigen::Matrix<double, 8, 8>>(whitener);
}

Eigen::Matrix<double, 8, 8> TagReprojection::whitener() const {
  return whitener_ ? *whitener_ : Eigen::Matrix<double, 8, 8>(diagonal_.asDiagonal());
}

bool TagReprojection::Linearize(const double* pose, Eigen::Matrix<double, 8, 1>* residual,
                                Eigen::Matrix<double, 8, 6>* jacobian) const {
  const bool on_body = mounted_on_ == MountedOn::kBody;
  const Eigen::Matrix3d world_from_body_rotation =
      Eigen::Map<const Eigen::Quaterniond>(pose).toRotationMatrix();
  const Eigen::Matrix3d body_from_world_rotation = world_from_body_rotation.transpose();
  const Eigen::Map<const Eigen::Vector3d> body_in_world(pose + 4);
  Eigen::Matrix<double, 8, 1> error;
  Eigen::Matrix<double, 8, 6> d_error;
  for (int i = 0; i < 4; ++i) {
    const auto c = static_cast<size_t>(i);
    Eigen::Vector3d beside_cam;  // in the frame that the camera is fixed to
    if (on_body) {
      beside_cam = body_from_world_rotation * (corners_in_world_[c] - body_in_world);
    } else {
      beside_cam = world_from_body_rotation * corners_in_world_[c] + body_in_world;
    }
    const Eigen::Vector3d corner_in_cam = cam_from_body_rotation_ * beside_cam + body_in_cam_;
    Eigen::Vector2d predicted;
    Eigen::Matrix<double, 2, 3> d_pixel_d_cam;
    if (!camera_.Project(corner_in_cam, &predicted, jacobian ? &d_pixel_d_cam : nullptr)) {
      return false;
    }
    error.segment<2>(2 * i) = predicted - pixels_[c];
    if (jacobian == nullptr) continue;
    const Eigen::Matrix<double, 2, 3> d_pixel = d_pixel_d_cam * cam_from_body_rotation_;
    if (on_body) {
      d_error.block<2, 3>(2 * i, 0) = d_pixel * Hat(beside_cam);
      d_error.block<2, 3>(2 * i, 3) = -d_pixel * body_from_world_rotation;
    } else {
      d_error.block<2, 3>(2 * i, 0) =
          -d_pixel * world_from_body_rotation * Hat(corners_in_world_[c]);
      d_error.block<2, 3>(2 * i, 3) = d_pixel;
    }
  }
  if (is_in_pixels_) {
    *residual = error;
    if (jacobian != nullptr) *jacobian = d_error;
    return true;
  }
  if (!whitener_) {
    *residual = diagonal_.cwiseProduct(error);
    if (jacobian != nullptr) *jacobian = diagonal_.asDiagonal() * d_error;
    return true;
  }
  // Eigen's blocked products lose time on matrices this small.
  *residual = whitener_->lazyProduct(error);
  if (jacobian != nullptr) *jacobian = whitener_->lazyProduct(d_error);
  return true;
}

bool TagReprojectionResidual::Evaluate(double const* const* parameters, double* residuals,
                                       double** jacobians) const {
  const bool wants_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, 6> jacobian;
  if (!Linearize(parameters[0], &residual, wants_jacobian ? &jacobian : nullptr)) return false;
  Eigen::Map<Eigen::Matrix<double, 8, 1>>{residuals} = residual;
  if (!wants_jacobian) return true;
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift;  // tangent -> ambient
  PoseManifold().MinusJacobian(parameters[0], lift.data());
  Eigen::Map<Eigen::Matrix<double, 8, 7, Eigen::RowMajor>>(jacobians[0]).noalias() =
      jacobian * lift;
  return true;
}

}  // namespace tagtwist::internal
