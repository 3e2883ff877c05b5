#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "frontend/types/body_state.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// Twist of cam relative to W, expressed in cam: [v(3) m/s; omega(3) rad/s].
using CameraTwist = Eigen::Matrix<double, 6, 1>;

/// One point's motion over the image: normalised coordinates, their rate, the depth along the
/// optical axis.
struct FlowPoint {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();  // x = X/Z, y = Y/Z
  Eigen::Vector2d flow = Eigen::Vector2d::Zero();   // [1/s]
  double depth_m = 0;
};

/// Rate of a fixed point's normalised coordinates per twist of cam in cam, 2x6: seed Eq. 9 with
/// the sign of its second row's omega_x corrected to +(1 + y^2).
Eigen::Matrix<double, 2, 6> InteractionMatrix(const Eigen::Vector2d& point, double depth_m);

/// Depth [m], along the optical axis, of the point of a plane that is seen at normalised
/// coordinates (seed Eqs. 6 and 7 for any plane z = 0 of the plane frame); nullopt when the ray
/// does not meet it before the camera.
std::optional<double> DepthOnPlane(const Eigen::Vector2d& point, const Pose& cam_from_plane);

/// Least-squares twist over the points at `indices` (seed: pseudo-inverse of Eq. 9); nullopt with
/// fewer than three points or a configuration that leaves a motion open.
std::optional<CameraTwist> SolveTwist(const std::vector<FlowPoint>& flow,
                                      const std::vector<size_t>& indices);
std::optional<CameraTwist> SolveTwist(const std::vector<FlowPoint>& flow);

/// Twist of the body from that of its camera (seed Eq. 11; velocity then expressed in W, the rate
/// in B).
Twist BodyTwist(const CameraTwist& twist_of_cam_in_cam, const Pose& cam_from_body,
                const Pose& world_from_body);

/// Twist of a body that a camera which stands in W sees, from what the camera would do if the body
/// stood.
Twist TwistSeenFrom(const CameraTwist& twist_of_cam_in_cam, const Pose& cam_from_world,
                    const Pose& world_from_body);

/// Seed Eq. 12, entry by entry: alpha * past + (1 - alpha) * now.
Twist LowPass(const Twist& past, const Twist& now, double alpha);

}  // namespace tagtwist::internal
