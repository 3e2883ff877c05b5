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

/// A camera and where it is fixed; the tags that it sees share one.
struct FixedCamera {
  FixedCamera(const Camera& the_camera, const Pose& cam_from_body, MountedOn fixed_to)
      : camera(the_camera),
        mounted_on(fixed_to),
        cam_from_body_rotation(cam_from_body.rotation().toRotationMatrix()),
        body_in_cam(cam_from_body.translation()) {}

  Camera camera;
  MountedOn mounted_on;
  Eigen::Matrix3d cam_from_body_rotation;  // or cam_from_world's
  Eigen::Vector3d body_in_cam;
};

/// Whitened reprojection of the four corners of a tag, 8x1, corner after corner:
///   r = W (u - pixels),   u_i = Project(cam_from_body * body_from_world * corner_in_world_i),
/// of a camera that stands in W, where the map's tags are the body's,
///                         u_i = Project(cam_from_world * world_from_body * corner_in_body_i),
/// W'W = inverse of the corners' covariance. One block, so that a robust loss judges the
/// tag as a whole: a wrong tag is wrong in all its corners.
class TagReprojection {
 public:
  TagReprojection(const TagObservation& observation, std::shared_ptr<const FixedCamera> camera);
  TagReprojection(const TagObservation& observation, const Camera& camera,
                  const Pose& cam_from_body, MountedOn mounted_on = MountedOn::kBody)
      : TagReprojection(observation,
                        std::make_shared<const FixedCamera>(camera, cam_from_body, mounted_on)) {}
  /// r at world_from_body (Pose::params), and its Jacobian in the pose's tangent [theta, rho],
  /// which may be nullptr. False when a corner lies behind the camera.
  bool Linearize(const double* pose, Eigen::Matrix<double, 8, 1>* residual,
                 Eigen::Matrix<double, 8, 6>* jacobian) const;

  /// The W of above, upper triangular.
  Eigen::Matrix<double, 8, 8> whitener() const;
  /// Whether W is the identity: the residual is in pixels.
  bool is_in_pixels() const { return whitener_ == nullptr && scale_ == 1; }
  /// log det of the inverse covariance of the pixels.
  double LogDetInformation() const { return 2 * whitener().diagonal().array().log().sum(); }
  const std::shared_ptr<const FixedCamera>& camera() const { return camera_; }

 private:
  std::array<Eigen::Vector3d, 4> corners_in_world_;
  std::array<Eigen::Vector2d, 4> pixels_;
  std::shared_ptr<const FixedCamera> camera_;
  double scale_ = 1;                                             // of W where that is all;
  std::unique_ptr<const Eigen::Matrix<double, 8, 8>> whitener_;  // W where it has more
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
