#pragma once
#include <Eigen/Core>
#include <array>

#include "frontend/types/body_state.h"
#include "frontend/types/camera.h"
#include "frontend/types/tag_map.h"
#include "residuals/lens.h"

namespace tagtwist::internal {

/// A camera that takes row v of its image line_time_s * v after the frame's stamp, and how it moves
/// meanwhile: velocity of its centre in W, rate in its own frame.
struct RollingShutter {
  double line_time_s = 0;  // < 0: from the last row up
  Twist motion;
};

/// A tag's reprojection with everything it depends on free, 8x1, corner after corner:
///   r = W (u - pixels),   u_i = Project(cam_from_world(t_i) * (scale * (world_from_tag *
///   corner_i))).
/// `scale` is that of the print: it stretches the whole map, sizes and positions alike. The camera
/// is where it was when the corner's row was taken, t_i = line_time_s * v_i after the stamp:
///   world_from_cam(t_i) = (R Exp(omega t_i), p + v_world t_i), R, p at the stamp.
struct TagCalibrationResidual {
  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, 6> by_cam;  // world_from_cam, tangent of pose.h
  Eigen::Matrix<double, 8, 7> by_tag;  // world_from_tag, tangent of pose.h; its bend [1/m]
  Eigen::Matrix<double, 8, 1> by_log_scale, by_line_time;  // [1/s]
  // Entries of lens.h.
  Eigen::Matrix<double, 8, Eigen::Dynamic, Eigen::ColMajor, 8, kMaxLensSize> by_lens;
};

/// Linearised at the arguments, W of CornerWhitener(); without `shared` only by the camera's pose.
/// False when a corner lies behind the camera.
bool EvaluateTagCalibration(const Tag& tag, double scale, const Camera& camera,
                            const Pose& world_from_cam,
                            const std::array<Eigen::Vector2d, 4>& pixels,
                            const Eigen::Matrix<double, 8, 8>& whitener,
                            const RollingShutter& shutter, TagCalibrationResidual* out,
                            bool shared = true);

}  // namespace tagtwist::internal
