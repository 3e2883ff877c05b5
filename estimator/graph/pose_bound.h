#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// What the tags of a frame say of its pose, to first order about a given one: J' R^-1 J and
/// -J' R^-1 r, summed over the tags.
struct PoseInformation {
  PoseCovariance information = PoseCovariance::Zero();
  PoseStep score = PoseStep::Zero();  // where they would have the pose, times the information
  double squared = 0;                 // r' R^-1 r
};
/// nullopt where a corner lies behind the camera.
std::optional<PoseInformation> InformationOfTags(const EstimatorSetup& setup,
                                                 double corner_sigma_px,
                                                 const Pose& world_from_body,
                                                 const std::vector<TagDetection>& tags);

/// Cramér-Rao bound of a pose from the tags of its own frame and nothing else: no unbiased
/// estimator has a smaller covariance. (sum J' R^-1 J)^-1 over the tags, J the derivative of a
/// tag's pixels by the pose at world_from_body, R the covariance of its corners at this noise.
/// nullopt where the tags do not fix the pose: there are none, or a corner lies behind the camera.
std::optional<PoseCovariance> PoseBound(const EstimatorSetup& setup, double corner_sigma_px,
                                        const Pose& world_from_body,
                                        const std::vector<TagDetection>& tags);

/// Inverse of an information matrix of a pose; nullopt where it is singular: a direction has next
/// to none beside the others, each in its own unit.
std::optional<PoseCovariance> InverseInformation(const PoseCovariance& information);

}  // namespace tagtwist::internal
