#pragma once
#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <unordered_map>
#include <vector>

#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// The planes that a map's tags lie on. Plane frame: z = 0 is the plane, z out of the paper. For
/// tags on the world's z = 0 it is W itself, so that the closed form works in the seed's numbers.
struct TagPlanes {
  std::vector<Pose> world_from_plane;
  std::unordered_map<int, size_t> plane_of_tag;  // by tag id, index into world_from_plane
};

/// Tags are on one plane when their corners lie within 2 mm of it and they face the same way. Bends
/// do not count: a bent tag lies on the plane that it is bent about.
TagPlanes FindTagPlanes(const std::vector<Tag>& tags);
/// The only one that FindTagPlanes finds; nullopt where it finds several, or none.
std::optional<Pose> CommonPlane(const std::vector<Tag>& tags);

/// Where on each plane its tags lie, x and y of the plane [m]: the box of their corners, a tag's
/// side added all round.
std::vector<Eigen::AlignedBox2d> TagRegions(const TagPlanes& planes, const std::vector<Tag>& tags);

/// The plane with the most of these tags (the first on a tie); all must be in the map. The list
/// must not be empty.
size_t MainPlane(const TagPlanes& planes, const std::vector<TagDetection>& tags);

}  // namespace tagtwist::internal
