#pragma once
#include <Eigen/Core>
#include <array>

#include "frontend/types/camera.h"
#include "frontend/types/tag_map.h"
#include "residuals/lens.h"

namespace tagtwist {

/// A tag's reprojection with everything it depends on free, 8x1, corner after corner:
///   r = W (u - pixels),   u_i = Project(cam_from_world * (scale * (world_from_tag * corner_i))).
/// `scale` is that of the print: it stretches the whole map, sizes and positions alike.
struct TagCalibrationResidual {
  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, 6> by_cam;  // world_from_cam, tangent of pose.h
  Eigen::Matrix<double, 8, 6> by_tag;  // world_from_tag, tangent of pose.h
  Eigen::Matrix<double, 8, 1> by_log_scale;
  // Entries of lens.h.
  Eigen::Matrix<double, 8, Eigen::Dynamic, Eigen::ColMajor, 8, kMaxLensSize> by_lens;
};

/// Linearised at the arguments, W of CornerWhitener(); without `shared` only by the camera's pose.
/// False when a corner lies behind the camera.
bool EvaluateTagCalibration(const Tag& tag, double scale, const Camera& camera,
                            const Pose& world_from_cam,
                            const std::array<Eigen::Vector2d, 4>& pixels,
                            const Eigen::Matrix<double, 8, 8>& whitener,
                            TagCalibrationResidual* out, bool shared = true);

}  // namespace tagtwist
