#pragma once
#include <optional>
#include <utility>

#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Ids of two tags whose black squares share more than a line on one side of one sheet, or nullopt.
/// A hundredth of a side is forgiven.
std::optional<std::pair<int, int>> FindOverlap(const TagMap& map);

}  // namespace tagtwist::internal
