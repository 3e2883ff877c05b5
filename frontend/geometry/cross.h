#pragma once
#include <Eigen/Core>

namespace tagtwist::internal {

/// The third component of the cross product of two vectors of a plane.
inline double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace tagtwist::internal
