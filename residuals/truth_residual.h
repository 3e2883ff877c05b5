#pragma once
#include <Eigen/Core>

#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// How a frame's camera lies to the ground truth, 6x1, not whitened:
///   r = [Log(R_truth' R); p - p_truth],   (R, p) = truth_from_world * world_from_cam *
///   cam_from_body,
/// the truth taken at the frame's stamp + offset.
struct TruthResidual {
  Eigen::Matrix<double, 6, 1> residual;  // [rad; m]
  // By the tangents of pose.h, and by the offset [1/s].
  Eigen::Matrix<double, 6, 6> by_cam, by_world, by_mount;
  Eigen::Matrix<double, 6, 1> by_offset;
};

/// `rate`: of the truth at that time, velocity in its world and body rate.
TruthResidual EvaluateTruth(const Pose& truth, const Twist& rate, const Pose& truth_from_world,
                            const Pose& world_from_cam, const Pose& cam_from_body);

}  // namespace tagtwist::internal
