#pragma once
#include <cstdint>
#include <vector>

#include "frontend/simulation/scene_parts.h"

namespace tagtwist::internal {

/// Papers that come closer to a plane keep it clean [m].
constexpr double kNearFloorM = 0.02;

/// Random polylines and blobs on the plane z = 0, between low and high (x and y [m]), off the
/// papers that lie on it. `plane` picks the draws; 0 is the floor.
std::vector<Patch> MakeScribbles(const Eigen::Vector2d& low, const Eigen::Vector2d& high,
                                 const std::vector<Patch>& papers, const SceneOptions& options,
                                 uint64_t plane = 0);

}  // namespace tagtwist::internal
