#pragma once
#include <optional>
#include <vector>

#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// Where a camera sits on a body, and the map in the ground truth's world.
struct HandEyeStart {
  Pose cam_from_body, truth_from_world;
};

/// From nothing but both paths, frame by frame: least squares of
///   A X = X B over pairs of frames, A = C_i^-1 C_j, B = B_i^-1 B_j, X = cam_from_body,
/// C world_from_cam and B truth_from_body; the rotation by quaternions (Chou and Kamel 1991, Eq. 13
/// to 18), then the translation, then the world as the mean over frames. nullopt where the turns
/// are about fewer than two axes, or those of both paths are not alike.
std::optional<HandEyeStart> FindHandEyeStart(const std::vector<Pose>& world_from_cam,
                                             const std::vector<Pose>& truth_from_body);

}  // namespace tagtwist::internal
