#pragma once
#include <vector>

#include "frontend/simulation/scene_parts.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// The black squares that Kalibr prints at the corners of the tags of a board, as wide as the gap
/// between neighbours; none on a map of another family, and none around a tag without a neighbour
/// on its left, on its right, above or below.
std::vector<Patch> MakeBoardSquares(const TagMap& map, double ink_grey);

}  // namespace tagtwist::internal
