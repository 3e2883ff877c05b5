#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "frontend/geometry/frame_pose.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// FindFramePose of tags that one or several cameras of a body have seen at the same time. Of
/// several each one's poses propose; the tags of all judge and refine them, so that a pose that one
/// camera leaves open is decided by the others.
FramePose FindPoseOfTags(const EstimatorSetup& setup, const std::vector<TagDetection>& tags);

/// MirroredPose along the line of sight of the camera that sees most of the tags, the first of
/// them.
std::optional<Pose> MirroredPoseOf(const EstimatorSetup& setup,
                                   const std::vector<TagDetection>& tags,
                                   const Pose& world_from_body);

}  // namespace tagtwist::internal
