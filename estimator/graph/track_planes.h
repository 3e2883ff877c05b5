#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "frontend/types/ray.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// A plane of the map's tags (see TagPlanes) and where on it they lie: the surface is known to be
/// there, so tracks within that region lie on the plane. Coordinates x, y of the plane [m].
struct TrackPlane {
  Pose world_from_plane;
  Eigen::AlignedBox2d region;  // see TagRegions
  std::vector<Eigen::Vector2d> tag_centres;
  double least_side_m = 0;                            // of its tags
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // in W, out of the paper
  double offset_m = 0;                                // normal . point, for the plane's points
};
std::vector<TrackPlane> FindTrackPlanes(const TagMap& map);

/// The plane that a ray meets (origin and direction in W): of those that it meets from their
/// fronts and within their regions, the nearest. Where others lie in the same surface there, as
/// the planes of single tags on an uneven mat do, it is the one whose tag is nearest to the point:
/// they are turned by less than 20 degrees against it and off by less than a quarter of a tag.
/// nullopt where there is none within 100 m.
std::optional<size_t> PlaneOfRay(const std::vector<TrackPlane>& planes, const Ray& ray);

}  // namespace tagtwist::internal
