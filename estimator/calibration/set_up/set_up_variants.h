#pragma once
#include <string>
#include <vector>

#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// A map in which ids run otherwise over the same grid.
struct SetUpVariant {
  std::string fact, advice;  // what it would mean
  TagMap map;
};

/// All of them, without the one as given.
std::vector<SetUpVariant> SetUpVariants(const TagMap& map);

}  // namespace tagtwist::internal
