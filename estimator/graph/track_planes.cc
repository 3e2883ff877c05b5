#include "estimator/graph/track_planes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "frontend/types/tag_planes.h"

namespace tagtwist::internal {
namespace {

constexpr double kMaxDistanceM = 100;
constexpr double kCosSameSurface = 0.94;  // of 20 degrees
constexpr double kOffsetInSides = 0.25;

struct Hit {
  double distance = 0;  // in lengths of the ray's direction
  Eigen::Vector3d in_world;
  Eigen::Vector2d in_plane;
};

// Where the ray meets the plane from its front, in the region of its tags.
std::optional<Hit> Meet(const TrackPlane& plane, const Ray& ray) {
  if (!(plane.normal.dot(ray.direction) < 0)) return std::nullopt;
  const double distance = DistanceToPlane(ray, plane.normal, plane.offset_m);
  if (!(distance > 0 && distance * ray.direction.norm() < kMaxDistanceM)) return std::nullopt;
  Hit hit;
  hit.distance = distance;
  hit.in_world = ray.At(distance);
  hit.in_plane = (Inverse(plane.world_from_plane) * hit.in_world).head<2>();
  if (!plane.region.contains(hit.in_plane)) return std::nullopt;
  return hit;
}

bool IsSameSurface(const TrackPlane& a, const TrackPlane& b, const Eigen::Vector3d& point) {
  const double most_m = kOffsetInSides * std::min(a.least_side_m, b.least_side_m);
  return a.normal.dot(b.normal) > kCosSameSurface &&
         std::abs(b.normal.dot(point) - b.offset_m) < most_m;
}

double SquaredDistanceToTag(const TrackPlane& plane, const Eigen::Vector2d& point) {
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& centre : plane.tag_centres) {
    least = std::min(least, (centre - point).squaredNorm());
  }
  return least;
}

}  // namespace

std::vector<TrackPlane> FindTrackPlanes(const TagMap& map) {
  const TagPlanes planes = FindTagPlanes(map.tags());
  const std::vector<Eigen::AlignedBox2d> regions = TagRegions(planes, map.tags());
  std::vector<TrackPlane> out;
  for (size_t i = 0; i < regions.size(); ++i) {
    TrackPlane plane;
    plane.world_from_plane = planes.world_from_plane[i];
    plane.region = regions[i];
    plane.least_side_m = std::numeric_limits<double>::infinity();
    plane.normal = plane.world_from_plane.rotation() * Eigen::Vector3d::UnitZ();
    plane.offset_m = plane.normal.dot(plane.world_from_plane.translation());
    out.push_back(plane);
  }
  for (const Tag& tag : map.tags()) {
    TrackPlane& plane = out[planes.plane_of_tag.at(tag.id)];
    const Eigen::Vector3d centre = tag.world_from_tag.translation();
    plane.tag_centres.emplace_back((Inverse(plane.world_from_plane) * centre).head<2>());
    plane.least_side_m = std::min(plane.least_side_m, tag.size_m);
  }
  return out;
}

std::optional<size_t> PlaneOfRay(const std::vector<TrackPlane>& planes, const Ray& ray) {
  std::vector<std::pair<size_t, Hit>> hits;
  size_t nearest = 0;
  for (size_t i = 0; i < planes.size(); ++i) {
    const auto hit = Meet(planes[i], ray);
    if (!hit) continue;
    if (!hits.empty() && hit->distance < hits[nearest].second.distance) nearest = hits.size();
    hits.emplace_back(i, *hit);
  }
  if (hits.size() < 2) return hits.empty() ? std::nullopt : std::optional<size_t>(hits[0].first);
  size_t best = nearest;
  double least = std::numeric_limits<double>::infinity();
  const TrackPlane& surface = planes[hits[nearest].first];
  for (size_t k = 0; k < hits.size(); ++k) {
    const TrackPlane& plane = planes[hits[k].first];
    if (!IsSameSurface(surface, plane, hits[nearest].second.in_world)) continue;
    const double squared = SquaredDistanceToTag(plane, hits[k].second.in_plane);
    if (squared < least) least = squared, best = k;
  }
  return hits[best].first;
}

}  // namespace tagtwist::internal
