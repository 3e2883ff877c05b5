#pragma once
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <array>

#include "frontend/types/camera.h"
#include "frontend/types/pose.h"

namespace tagtwist {

/// Corners of one tag: where they are, where they were seen, how well (one pixel covariance each).
struct TagObservation {
  std::array<Eigen::Vector3d, 4> corners_in_world;   // [m]
  std::array<Eigen::Vector2d, 4> pixels;             // [px]
  std::array<Eigen::Matrix2d, 4> pixel_covariances;  // [px^2]
};

/// Whitened reprojection of the four corners of a tag, 8x1, corner after corner:
///   r_i = W_i (Project(cam_from_body * body_from_world * corner_in_world_i) - pixel_i),
/// W_i'W_i = inverse of corner i's pixel covariance. One block, so that a robust loss judges the
/// tag as a whole: a wrong tag is wrong in all its corners. Block 0: world_from_body (Pose::params,
/// PoseManifold). Evaluate returns false when a corner lies behind the camera.
class TagReprojectionResidual final : public ceres::SizedCostFunction<8, 7> {
 public:
  TagReprojectionResidual(const TagObservation& observation, const Camera& camera,
                          const Pose& cam_from_body);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  std::array<Eigen::Vector3d, 4> corners_in_world_;
  std::array<Eigen::Vector2d, 4> pixels_;
  std::array<Eigen::Matrix2d, 4> whiteners_;
  Camera camera_;
  Eigen::Matrix3d cam_from_body_rotation_;
  Eigen::Vector3d body_in_cam_;
};

}  // namespace tagtwist
