#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frontend/simulation/renderer_options.h"
#include "frontend/types/tag_family.h"

namespace tagtwist::internal {

/// A flat patch: the points centre + u half_u + v half_v with |u|, |v| <= 1 (rectangle) or
/// u^2 + v^2 <= 1 (ellipse), in W [m].
struct Patch {
  enum class Shape { kRectangle, kEllipse };
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_u = Eigen::Vector3d::UnitX(), half_v = Eigen::Vector3d::UnitY();
  Shape shape = Shape::kRectangle;
  double grey = 0;                      // of a plain patch
  const TagPattern* pattern = nullptr;  // of a tag: u to the right, v up as printed
};

/// What carries tags that are not on the floor, a rectangle, and what is drawn on it.
struct WallSheet {
  Patch sheet;
  std::vector<Patch> scribbles;
};

/// True when the patch hides the point from the camera's centre.
bool Hides(const Patch& patch, const Eigen::Vector3d& camera_in_world,
           const Eigen::Vector3d& point_in_world);

}  // namespace tagtwist::internal
