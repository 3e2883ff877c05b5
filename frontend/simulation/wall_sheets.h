#pragma once
#include <vector>

#include "frontend/simulation/scene_parts.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// A sheet for each plane of the map's tags that is not the floor (or of all
/// where there is none): the box of its tags' corners, a
/// tag's side added all round, behind all of its papers; scribble on it as on the floor.
std::vector<WallSheet> MakeWallSheets(const TagMap& map, const std::vector<Patch>& papers,
                                      const SceneOptions& options);

}  // namespace tagtwist::internal
