#include "frontend/simulation/scene_parts.h"

#include <Eigen/LU>
#include <cmath>

namespace tagtwist::internal {

// The point on the ray to `point`, p = camera + s (point - camera), lies on the patch's plane at
// s = 1 / w with [u v 1]' / s = [half_u half_v centre - camera]^-1 (point - camera) =: [a b w]'.
bool Hides(const Patch& patch, const Eigen::Vector3d& camera_in_world,
           const Eigen::Vector3d& point_in_world) {
  Eigen::Matrix3d axes;
  axes << patch.half_u, patch.half_v, patch.centre - camera_in_world;
  if (!(std::abs(axes.determinant()) > 0)) return false;
  const Eigen::Vector3d abw = axes.inverse() * (point_in_world - camera_in_world);
  if (!(abw.z() > 1 + 1e-9)) return false;  // behind the point, or its own plane
  const double u = abw.x() / abw.z(), v = abw.y() / abw.z();
  if (patch.shape == Patch::Shape::kEllipse) return u * u + v * v <= 1;
  return std::abs(u) <= 1 && std::abs(v) <= 1;
}

}  // namespace tagtwist::internal
