#pragma once
#include <cstdint>
#include <vector>

#include "frontend/scene.h"

namespace tagtwist {

/// Random polylines and blobs on the plane z = 0, between low and high (x and y, W [m]), off the
/// papers that lie on the floor.
std::vector<Patch> MakeScribbles(const Eigen::Vector2d& low, const Eigen::Vector2d& high,
                                 const std::vector<Patch>& papers, const SceneOptions& options);

}  // namespace tagtwist
