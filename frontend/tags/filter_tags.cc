#include "frontend/tags/filter_tags.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <unordered_map>

#include "frontend/geometry/tag_outline.h"

namespace tagtwist {

using namespace internal;

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

namespace {

Eigen::Vector2d CentreOf(const TagDetection& tag) {
  return 0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]);
}

bool AreApart(const TagDetection& a, const TagDetection& b) {
  return CentreOf(a).allFinite() && CentreOf(b).allFinite() && !IsInside(CentreOf(a), b.corners) &&
         !IsInside(CentreOf(b), a.corners);
}

}  // namespace

std::vector<int> DoubledIds(const std::vector<TagDetection>& tags, const TagMap& map) {
  std::set<int> out;
  for (size_t i = 0; i < tags.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      if (tags[i].id != tags[j].id || map.Find(tags[i].id) == nullptr) continue;
      if (AreApart(tags[i], tags[j])) out.insert(tags[i].id);
    }
  }
  return {out.begin(), out.end()};
}

}  // namespace tagtwist
