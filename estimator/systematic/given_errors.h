#pragma once
#include <Eigen/Core>

#include "estimator/graph/graph_builder.h"
#include "frontend/types/measurements.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// A square root of what is given of a camera's lens and mount (RigCamera::covariance), without
/// columns that are next to nothing: entries x columns, one of zeros where nothing is given. The
/// options' focal_sigma takes the place of what the camera says of its focal length, correlations
/// included.
Eigen::MatrixXd RootOfGiven(const MountedCamera& camera, const EstimatorOptions& options);

/// What a unit of each of those entries, of the camera that saw the tag, adds to its seen corners,
/// 8 x entries. `by_mount`: the same of a turn of the mount in the body and a shift of it in the
/// body (in W where the camera stands).
Eigen::MatrixXd CornersByEntries(const EstimatorSetup& setup, const Pose& world_from_body,
                                 const TagDetection& tag,
                                 const Eigen::Matrix<double, 8, 6>& by_mount);

}  // namespace tagtwist::internal
