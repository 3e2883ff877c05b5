#include "frontend/geometry/quad_shape.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "frontend/geometry/cross.h"
#include "frontend/geometry/homography.h"
#include "frontend/geometry/pose_refine.h"

namespace tagtwist::internal {
namespace {

using Quad = std::array<Eigen::Vector2d, 4>;

// Corners of the square of side 2, p1..p4.
std::vector<Eigen::Vector2d> UnitSquare() {
  return {Eigen::Vector2d(-1, -1), {1, -1}, {1, 1}, {-1, 1}};
}

// The pose under which the square looks the same from afar: mirrored along the line of sight to its
// centre.
Pose Mirrored(const Pose& cam_from_tag) {
  const Eigen::Vector3d sight = cam_from_tag.translation().normalized();
  const Eigen::Matrix3d rotation = (Eigen::Matrix3d::Identity() - 2 * sight * sight.transpose()) *
                                   cam_from_tag.rotation().toRotationMatrix() *
                                   Eigen::Vector3d(1, 1, -1).asDiagonal();
  return MakePose(Eigen::Quaterniond(rotation), cam_from_tag.translation());
}

// Without its tilt: turned about the line of sight only.
Pose FaceOn(const Pose& cam_from_tag) {
  const Eigen::Vector3d normal = cam_from_tag.rotation() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d sight = -cam_from_tag.translation().normalized();
  return MakePose(Eigen::Quaterniond::FromTwoVectors(normal, sight) * cam_from_tag.rotation(),
                  cam_from_tag.translation());
}

// How the homography [r1 r2 t] from the unit square to four rays breaks what holds for every pose:
// r1 r2 = 0 and |r1| = |r2|, relative to their squares. The homography in closed form: Heckbert,
// Fundamentals of texture mapping and image warping, 1989, section 2.2.3.
Eigen::Vector2d BrokenRules(const Quad& q) {
  const Eigen::Vector2d sum = q[0] - q[1] + q[2] - q[3], a = q[1] - q[2], b = q[3] - q[2];
  const double area = Cross(a, b), g = Cross(sum, b) / area, h = Cross(a, sum) / area;
  Eigen::Vector3d r1, r2;
  r1 << q[1] - q[0] + g * q[1], g;
  r2 << q[3] - q[0] + h * q[3], h;
  const double n1 = r1.squaredNorm(), n2 = r2.squaredNorm();
  return Eigen::Vector2d(2 * r1.dot(r2), n1 - n2) / (n1 + n2);
}

}  // namespace

QuadTurn TurnOf(const Quad& corners) {
  constexpr double kLeastHeightPx = 3;
  double longest = 0;
  for (size_t c = 0; c < 4; ++c) {
    longest = std::max(longest, (corners[(c + 1) % 4] - corners[c]).norm());
  }
  const double area = 0.5 * Cross(corners[2] - corners[0], corners[3] - corners[1]);
  if (!std::isfinite(area)) return QuadTurn::kNone;
  if (std::abs(area) < kLeastHeightPx * longest) return QuadTurn::kFlat;
  for (size_t c = 0; c < 4; ++c) {
    const Eigen::Vector2d in = corners[(c + 1) % 4] - corners[c];
    const Eigen::Vector2d out = corners[(c + 2) % 4] - corners[(c + 1) % 4];
    if (!(Cross(in, out) * area > 0)) return QuadTurn::kNone;
  }
  // Rows are counted downwards: what turns anticlockwise to the eye has a negative area.
  return area < 0 ? QuadTurn::kAnticlockwise : QuadTurn::kClockwise;
}

std::optional<double> SquareMisfitPx(const Quad& corners, const Camera& camera) {
  std::vector<Eigen::Vector2d> rays;
  std::vector<PointInImage> points;
  const std::vector<Eigen::Vector2d> square = UnitSquare();
  for (size_t c = 0; c < 4; ++c) {
    const auto ray = camera.Unproject(corners[c]);
    if (!ray) return std::nullopt;
    rays.push_back(*ray);
    points.push_back({{square[c].x(), square[c].y(), 0}, corners[c]});
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto image_from_square = FitHomography(square, rays, /*normalise=*/true);
  if (!image_from_square) return kInfinity;
  const auto cam_from_tag = PoseFromHomography(*image_from_square, square, /*seed_scale=*/false);
  if (!cam_from_tag) return kInfinity;
  // Both minima, from each other's mirror, and from a view face-on: of a small tag the search from
  // one start may end in the trough between.
  double least = kInfinity;
  const auto refine = [&](const Pose& start) {
    const RefinedPose refined = RefinePose(start, points, camera);
    if (refined.squared_error_px2 < least) least = refined.squared_error_px2;
    return refined.cam_from_world;
  };
  refine(Mirrored(refine(Mirrored(refine(*cam_from_tag)))));
  refine(Mirrored(*cam_from_tag));
  refine(FaceOn(*cam_from_tag));
  return std::sqrt(least);
}

std::optional<double> ApproximateSquareMisfitPx(const Quad& corners, const Camera& camera) {
  Quad rays;
  std::array<Eigen::Matrix2d, 4> d_rays;
  double length = 0;
  for (size_t c = 0; c < 4; ++c) {
    const auto ray = camera.Unproject(corners[c], &d_rays[c]);
    if (!ray) return std::nullopt;
    rays[c] = *ray;
    length = std::max(length, (rays[c] - rays[0]).norm());
  }
  const Eigen::Vector2d broken = BrokenRules(rays);
  const double step = 1e-6 * length;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (size_t c = 0; c < 4; ++c) {
    Eigen::Matrix2d by_ray;
    for (int axis = 0; axis < 2; ++axis) {
      Quad moved = rays;
      moved[c][axis] += step;
      by_ray.col(axis) = (BrokenRules(moved) - broken) / step;
    }
    const Eigen::Matrix2d by_pixel = by_ray * d_rays[c];
    covariance += by_pixel * by_pixel.transpose();
  }
  const double squared = broken.dot(covariance.inverse() * broken);
  return std::isfinite(squared) ? std::sqrt(std::max(squared, 0.0))
                                : std::numeric_limits<double>::infinity();
}

}  // namespace tagtwist::internal
