#pragma once
#include <string>

#include "frontend/base/result.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// A tag map as an SVG picture in true size (millimetres), to print at 100 % or to look at: one
/// sheet for every plane of tags, side by side, each seen from its front with its x axis to the
/// right, and a bar of 100 mm. A tag's id is its tooltip. Errors: as CheckTagMap.
Result<std::string> MapSvg(const TagMap& map);

/// "36 tags of tag36h11b2, ids 0 to 35, 88 mm, on 1 plane, 0.66 x 0.66 x 0.00 m".
std::string DescribeMap(const TagMap& map);

}  // namespace tagtwist::internal
