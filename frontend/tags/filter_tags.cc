#include "frontend/tags/filter_tags.h"

#include <algorithm>
#include <iterator>
#include <unordered_map>

namespace tagtwist {

std::vector<TagDetection> FilterTags(const std::vector<TagDetection>& tags, const TagMap& map,
                                     const Camera& camera, double border_px) {
  std::unordered_map<int, int> times_seen;
  for (const TagDetection& tag : tags) ++times_seen[tag.id];
  std::vector<TagDetection> usable;
  std::copy_if(tags.begin(), tags.end(), std::back_inserter(usable), [&](const TagDetection& tag) {
    // Contains() is false for a corner that is not finite.
    return map.Find(tag.id) != nullptr && times_seen[tag.id] == 1 &&
           std::all_of(tag.corners.begin(), tag.corners.end(), [&](const Eigen::Vector2d& corner) {
             return camera.Contains(corner, border_px);
           });
  });
  std::sort(usable.begin(), usable.end(),
            [](const TagDetection& a, const TagDetection& b) { return a.id < b.id; });
  return usable;
}

}  // namespace tagtwist
