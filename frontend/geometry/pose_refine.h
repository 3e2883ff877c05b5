#pragma once
#include <Eigen/Core>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// A known point and the pixel that it was seen at.
struct PointInImage {
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct RefinedPose {
  Pose cam_from_world;
  double squared_error_px2 = 0;  // sum of |predicted - seen|^2; infinite when the start had points
                                 // behind the camera
};

/// Least squares over the points' reprojection with the full camera model, by Levenberg-Marquardt
/// from a start. It ends in the minimum whose basin the start lies in.
RefinedPose RefinePose(const Pose& cam_from_world, const std::vector<PointInImage>& points,
                       const Camera& camera);

}  // namespace tagtwist::internal
