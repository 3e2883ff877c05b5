#pragma once
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>

#include "frontend/types/camera.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// Whitened reprojection of a tracked point that lies on a known plane, 2x1:
///   r = (Project(cam_from_body * body_from_world * world_from_plane * (x, y, 0)) - pixel) / sigma.
/// Block 0: world_from_body (Pose::params, PoseManifold). Block 1: the point (x, y) on the plane
/// [m]. Evaluate returns false when the point lies behind the camera.
class TrackResidual final : public ceres::SizedCostFunction<2, 7, 2> {
 public:
  TrackResidual(const Eigen::Vector2d& pixel, double sigma_px, const Pose& world_from_plane,
                const Camera& camera, const Pose& cam_from_body);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector2d pixel_;
  double inverse_sigma_;
  Eigen::Matrix<double, 3, 2> d_world_d_point_;
  Eigen::Vector3d plane_in_world_;
  Camera camera_;
  Eigen::Matrix3d cam_from_body_rotation_;
  Eigen::Vector3d body_in_cam_;
};

}  // namespace tagtwist::internal
