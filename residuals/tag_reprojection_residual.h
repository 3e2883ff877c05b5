#pragma once
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <array>
#include <memory>

#include "frontend/types/camera.h"
#include "frontend/types/pose.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {

/// Corners of one tag: where they are, where they were seen, how well.
struct TagObservation {
  std::array<Eigen::Vector3d, 4> corners_in_world;  // [m]
  std::array<Eigen::Vector2d, 4> pixels;            // [px]
  Eigen::Matrix<double, 8, 8> covariance;           // of u1 v1 .. u4 v4 [px^2]
};

/// Whitened reprojection of the four corners of a tag, 8x1, corner after corner:
///   r = W (u - pixels),   u_i = Project(cam_from_body * body_from_world * corner_in_world_i),
/// of a camera that stands in W, where the map's tags are the body's,
///                         u_i = Project(cam_from_world * world_from_body * corner_in_body_i),
/// W'W = inverse of the corners' covariance. One block, so that a robust loss judges the
/// tag as a whole: a wrong tag is wrong in all its corners.
class TagReprojection {
 public:
  TagReprojection(const TagObservation& observation, const Camera& camera,
                  const Pose& cam_from_body, MountedOn mounted_on = MountedOn::kBody);
  /// r at world_from_body (Pose::params), and its Jacobian in the pose's tangent [theta, rho],
  /// which may be nullptr. False when a corner lies behind the camera.
  bool Linearize(const double* pose, Eigen::Matrix<double, 8, 1>* residual,
                 Eigen::Matrix<double, 8, 6>* jacobian) const;

  /// The W of above, upper triangular.
  Eigen::Matrix<double, 8, 8> whitener() const;
  /// Whether W is the identity: the residual is in pixels.
  bool is_in_pixels() const { return is_in_pixels_; }
  /// log det of the inverse covariance of the pixels.
  double LogDetInformation() const { return 2 * diagonal_.array().log().sum(); }

 private:
  std::array<Eigen::Vector3d, 4> corners_in_world_;
  std::array<Eigen::Vector2d, 4> pixels_;
  bool is_in_pixels_ = false;
  Camera camera_;
  MountedOn mounted_on_;
  Eigen::Matrix3d cam_from_body_rotation_;  // or cam_from_world's
  Eigen::Vector3d body_in_cam_;
  Eigen::Matrix<double, 8, 1> diagonal_;                         // of W
  std::unique_ptr<const Eigen::Matrix<double, 8, 8>> whitener_;  // W, where it has more than that
};

/// The same as a cost. Block 0: world_from_body (Pose::params, PoseManifold). Evaluate returns
/// false when a corner lies behind the camera.
class TagReprojectionResidual final : public ceres::SizedCostFunction<8, 7>,
                                      public TagReprojection {
 public:
  using TagReprojection::TagReprojection;
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
};

}  // namespace tagtwist::internal
