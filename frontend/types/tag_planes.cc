#include "frontend/types/tag_planes.h"

#include <algorithm>
#include <cmath>

namespace tagtwist::internal {
namespace {

constexpr double kOnPlaneM = 2e-3;
constexpr double kWorldPlaneM = 1e-9;

// True when a tag's corners, its bend left aside, lie within `tolerance_m` of the plane and its z
// points the same way.
bool IsOnPlane(const Tag& tag, const Pose& world_from_plane, double tolerance_m) {
  Tag in_plane = tag;
  in_plane.bend_m = 0;
  in_plane.world_from_tag = Inverse(world_from_plane) * tag.world_from_tag;
  if (!((in_plane.world_from_tag.rotation() * Eigen::Vector3d::UnitZ()).z() > 0)) return false;
  const auto corners = TagCornersInWorld(in_plane);
  return std::all_of(corners.begin(), corners.end(), [&](const Eigen::Vector3d& corner) {
    return std::abs(corner.z()) <= tolerance_m;
  });
}

// The first tag's plane: that of W where it lies on it.
Pose PlaneOf(const Tag& tag) {
  return IsOnPlane(tag, Pose(), kWorldPlaneM) ? Pose() : tag.world_from_tag;
}

}  // namespace

std::optional<Pose> CommonPlane(const std::vector<Tag>& tags) {
  if (tags.empty()) return std::nullopt;
  const Pose plane = PlaneOf(tags.front());
  const bool all = std::all_of(tags.begin() + 1, tags.end(),
                               [&](const Tag& tag) { return IsOnPlane(tag, plane, kOnPlaneM); });
  return all ? std::optional(plane) : std::nullopt;
}

TagPlanes FindTagPlanes(const std::vector<Tag>& tags) {
  TagPlanes planes;
  for (const Tag& tag : tags) {
    size_t plane = 0;
    while (plane < planes.world_from_plane.size() &&
           !IsOnPlane(tag, planes.world_from_plane[plane], kOnPlaneM)) {
      ++plane;
    }
    if (plane == planes.world_from_plane.size()) {
      planes.world_from_plane.push_back(PlaneOf(tag));
    }
    planes.plane_of_tag.emplace(tag.id, plane);
  }
  return planes;
}

std::vector<Eigen::AlignedBox2d> TagRegions(const TagPlanes& planes, const std::vector<Tag>& tags) {
  std::vector<Pose> plane_from_world;
  for (const Pose& pose : planes.world_from_plane) plane_from_world.push_back(Inverse(pose));
  std::vector<Eigen::AlignedBox2d> out(plane_from_world.size());
  for (const Tag& tag : tags) {
    const size_t plane = planes.plane_of_tag.at(tag.id);
    const Eigen::Vector2d side = Eigen::Vector2d::Constant(tag.size_m);
    for (const Eigen::Vector3d& corner : TagCornersInWorld(tag)) {
      const Eigen::Vector2d point = (plane_from_world[plane] * corner).head<2>();
      out[plane].extend(point - side).extend(Eigen::Vector2d(point + side));
    }
  }
  return out;
}

size_t MainPlane(const TagPlanes& planes, const std::vector<TagDetection>& tags) {
  std::vector<int> votes(planes.world_from_plane.size(), 0);
  for (const TagDetection& tag : tags) ++votes[planes.plane_of_tag.at(tag.id)];
  return static_cast<size_t>(std::max_element(votes.begin(), votes.end()) - votes.begin());
}

}  // namespace tagtwist::internal
