#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "frontend/geometry/frame_pose.h"

namespace tagtwist::internal {

/// The poses that a frame's tags leave open.
struct PoseChoice {
  int64_t t_ns = 0;
  std::vector<TagDetection> tags;  // that agree
  std::vector<Pose> poses;         // world_from_body; none: no usable tag
};

/// The chain of poses, one a frame that has any, that corners and attitudes from frame to frame are
/// likeliest with (Viterbi): the squares of a pose's reprojection errors, and of the turn to the
/// next frame's against what corner noise makes of both and 1 rad/s of turning adds. Corner noise
/// scales both alike, so its value hardly matters. nullopt where there is no pose.
std::vector<std::optional<Pose>> LikeliestPath(const EstimatorSetup& setup,
                                               const std::vector<PoseChoice>& choices);

}  // namespace tagtwist::internal
