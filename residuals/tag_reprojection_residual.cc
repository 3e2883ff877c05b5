#include "residuals/tag_reprojection_residual.h"

#include <utility>

#include "frontend/types/so3.h"
#include "residuals/corner_whitener.h"
#include "residuals/pose_manifold.h"

namespace tagtwist::internal {

TagReprojection::TagReprojection(const TagObservation& observation,
                                 std::shared_ptr<const FixedCamera> camera)
    : corners_in_world_(observation.corners_in_world),
      pixels_(observation.pixels),
      camera_(std::move(camera)) {
  const Eigen::Matrix<double, 8, 8> whitener = CornerWhitener(observation.covariance);
  scale_ = whitener(0, 0);
  if (whitener == scale_ * Eigen::Matrix<double, 8, 8>::Identity()) return;
  whitener_ = std::make_unique<const Eigen::Matrix<double, 8, 8>>(whitener);
}

Eigen::Matrix<double, 8, 8> TagReprojection::whitener() const {
  if (whitener_) return *whitener_;
  return scale_ * Eigen::Matrix<double, 8, 8>::Identity();
}

bool TagReprojection::Linearize(const double* pose, Eigen::Matrix<double, 8, 1>* residual,
                                Eigen::Matrix<double, 8, 6>* jacobian) const {
  const FixedCamera& fixed = *camera_;
  const bool on_body = fixed.mounted_on == MountedOn::kBody;
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
    const Eigen::Vector3d corner_in_cam =
        fixed.cam_from_body_rotation * beside_cam + fixed.body_in_cam;
    Eigen::Vector2d predicted;
    Eigen::Matrix<double, 2, 3> d_pixel_d_cam;
    if (!fixed.camera.Project(corner_in_cam, &predicted, jacobian ? &d_pixel_d_cam : nullptr)) {
      return false;
    }
    error.segment<2>(2 * i) = predicted - pixels_[c];
    if (jacobian == nullptr) continue;
    const Eigen::Matrix<double, 2, 3> d_pixel = d_pixel_d_cam * fixed.cam_from_body_rotation;
    if (on_body) {
      d_error.block<2, 3>(2 * i, 0) = d_pixel * Hat(beside_cam);
      d_error.block<2, 3>(2 * i, 3) = -d_pixel * body_from_world_rotation;
    } else {
      d_error.block<2, 3>(2 * i, 0) =
          -d_pixel * world_from_body_rotation * Hat(corners_in_world_[c]);
      d_error.block<2, 3>(2 * i, 3) = d_pixel;
    }
  }
  if (is_in_pixels()) {
    *residual = error;
    if (jacobian != nullptr) *jacobian = d_error;
  } else if (!whitener_) {
    *residual = scale_ * error;
    if (jacobian != nullptr) *jacobian = scale_ * d_error;
  } else {
    // Eigen's blocked products lose time on matrices this small.
    *residual = whitener_->lazyProduct(error);
    if (jacobian != nullptr) *jacobian = whitener_->lazyProduct(d_error);
  }
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
