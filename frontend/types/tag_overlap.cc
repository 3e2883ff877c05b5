#include "frontend/types/tag_overlap.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tagtwist::internal {
namespace {

constexpr double kForgiven = 0.01;       // of a side
constexpr double kSameDirection = 0.99;  // cosine between normals of one sheet
using Corners = std::array<Eigen::Vector3d, 4>;

// How far along `axis` (a unit vector) the two squares overlap; negative when they are apart.
double OverlapAlong(const Eigen::Vector3d& axis, const Corners& a, const Corners& b) {
  const auto bounds = [&](const Corners& corners) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Eigen::Vector3d& corner : corners) {
      low = std::min(low, axis.dot(corner));
      high = std::max(high, axis.dot(corner));
    }
    return std::pair(low, high);
  };
  const auto [low_a, high_a] = bounds(a);
  const auto [low_b, high_b] = bounds(b);
  return std::min(high_a, high_b) - std::max(low_a, low_b);
}

// Separating axes: the directions of the sides of both.
bool Overlap(const Tag& a, const Tag& b, const Corners& corners_a, const Corners& corners_b) {
  const double side_m = std::min(a.size_m, b.size_m);
  const Eigen::Vector3d apart = b.world_from_tag.translation() - a.world_from_tag.translation();
  if (apart.norm() > 0.71 * (a.size_m + b.size_m)) return false;
  const Eigen::Vector3d normal_a = a.world_from_tag.rotation() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d normal_b = b.world_from_tag.rotation() * Eigen::Vector3d::UnitZ();
  const bool one_sheet =
      normal_a.dot(normal_b) > kSameDirection && std::abs(normal_a.dot(apart)) < 0.1 * side_m;
  if (!one_sheet) return false;
  for (const Tag* tag : {&a, &b}) {
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector3d axis = tag->world_from_tag.rotation() * Eigen::Vector3d::Unit(k);
      if (!(OverlapAlong(axis, corners_a, corners_b) > kForgiven * side_m)) return false;
    }
  }
  return true;
}

}  // namespace

std::optional<std::pair<int, int>> FindOverlap(const TagMap& map) {
  const auto& tags = map.tags();
  for (size_t i = 0; i < tags.size(); ++i) {
    for (size_t k = i + 1; k < tags.size(); ++k) {
      if (Overlap(tags[i], tags[k], map.CornersInWorld(tags[i].id),
                  map.CornersInWorld(tags[k].id))) {
        return std::pair(tags[i].id, tags[k].id);
      }
    }
  }
  return std::nullopt;
}

}  // namespace tagtwist::internal
