#pragma once
#include <Eigen/Core>

namespace tagtwist::internal {

/// A half line: the points origin + distance * direction, distance > 0 and counted in lengths of
/// the direction, which need not be one.
struct Ray {
  Eigen::Vector3d origin, direction;

  Eigen::Vector3d At(double distance) const { return origin + distance * direction; }
};

/// The distance at which the ray's line meets the plane normal . x = offset, whatever the length of
/// the normal. Negative where that is behind the origin; infinite or NaN where they are parallel,
/// so that a caller has to ask for a range.
inline double DistanceToPlane(const Ray& ray, const Eigen::Vector3d& normal, double offset) {
  return (offset - normal.dot(ray.origin)) / normal.dot(ray.direction);
}

}  // namespace tagtwist::internal
