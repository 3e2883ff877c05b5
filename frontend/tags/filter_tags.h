#pragma once
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

/// Tags that the estimator may use: in the map, once each (repeated ids are all dropped), finite,
/// all corners at least border_px inside the image. Sorted by id.
std::vector<TagDetection> FilterTags(const std::vector<TagDetection>& tags, const TagMap& map,
                                     const Camera& camera, double border_px);

/// Ids of the map that are seen at two places at once, sorted: repeated, none of the two within the
/// other.
std::vector<int> DoubledIds(const std::vector<TagDetection>& tags, const TagMap& map);

}  // namespace tagtwist
