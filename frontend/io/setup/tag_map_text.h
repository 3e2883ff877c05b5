#pragma once
#include <string>
#include <vector>

#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// The section `tag_map` of a configuration, numbers in the shortest form that reads back. `notes`:
/// a comment for each tag, or none at all.
std::string FormatTagMap(const TagMap& map, const std::vector<std::string>& notes = {});

/// "[1, 0.5]", the numbers as FormatTagMap writes them.
std::string FormatNumberList(const Eigen::VectorXd& values);

}  // namespace tagtwist::internal
