#include "frontend/types/camera.h"

#include <Eigen/LU>
#include <cmath>
#include <utility>

namespace tagtwist {
namespace {

constexpr double kMinDepthM = 1e-3;
constexpr int kMaxImageSide = 16384;  // [px]

// Brown-Conrady distortion of normalised coordinates, and its 2x2 Jacobian.
Eigen::Vector2d Distort(const Camera& c, const Eigen::Vector2d& n, Eigen::Matrix2d* jacobian) {
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  if (jacobian != nullptr) {
    const double d_radial_d_r2 = c.k1 + r2 * (2 * c.k2 + r2 * 3 * c.k3);
    const double cross = 2 * x * y * d_radial_d_r2 + 2 * c.p1 * x + 2 * c.p2 * y;
    *jacobian << radial + 2 * x * x * d_radial_d_r2 + 2 * c.p1 * y + 6 * c.p2 * x, cross, cross,
        radial + 2 * y * y * d_radial_d_r2 + 6 * c.p1 * y + 2 * c.p2 * x;
  }
  return {x * radial + 2 * c.p1 * x * y + c.p2 * (r2 + 2 * x * x),
          y * radial + c.p1 * (r2 + 2 * y * y) + 2 * c.p2 * x * y};
}

}  // namespace

bool Camera::Project(const Eigen::Vector3d& point_in_cam, Eigen::Vector2d* pixel,
                     Eigen::Matrix<double, 2, 3>* d_pixel_d_point) const {
  if (!(point_in_cam.z() >= kMinDepthM)) return false;
  const double iz = 1.0 / point_in_cam.z();
  const Eigen::Vector2d normalised = point_in_cam.head<2>() * iz;
  Eigen::Matrix2d d_distorted = Eigen::Matrix2d::Identity();
  const Eigen::Vector2d distorted =
      IsDistorted() ? Distort(*this, normalised, &d_distorted) : normalised;
  *pixel << fx * distorted.x() + cx, fy * distorted.y() + cy;
  if (d_pixel_d_point != nullptr) {
    Eigen::Matrix<double, 2, 3> d_normalised;
    d_normalised << iz, 0, -normalised.x() * iz, 0, iz, -normalised.y() * iz;
    *d_pixel_d_point = Eigen::Vector2d(fx, fy).asDiagonal() * d_distorted * d_normalised;
  }
  return true;
}

std::optional<Eigen::Vector2d> Camera::Unproject(const Eigen::Vector2d& pixel,
                                                 Eigen::Matrix2d* d_normalised_d_pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  Eigen::Vector2d normalised = distorted;
  Eigen::Matrix2d jacobian = Eigen::Matrix2d::Identity();
  if (IsDistorted()) {
    constexpr int kMaxNewtonSteps = 50;
    double error = 1;
    for (int i = 0; i < kMaxNewtonSteps && error > 1e-14; ++i) {
      const Eigen::Vector2d miss = distorted - Distort(*this, normalised, &jacobian);
      if (!(jacobian.determinant() > 1e-6)) return std::nullopt;  // past the fold of the lens
      normalised += jacobian.inverse() * miss;
      error = miss.norm();
    }
    if (!(error < 1e-9)) return std::nullopt;
    Distort(*this, normalised, &jacobian);
  }
  if (d_normalised_d_pixel != nullptr) {
    *d_normalised_d_pixel =
        jacobian.inverse() * Eigen::Vector2d(1.0 / fx, 1.0 / fy).asDiagonal().toDenseMatrix();
  }
  return normalised;
}

std::optional<std::string> Camera::Problem() const {
  for (const auto& [key, size] : {std::pair("width", width), std::pair("height", height)}) {
    if (size < 1 || size > kMaxImageSide) {
      return std::string(key) + ": expected 1.." + std::to_string(kMaxImageSide) + ", got " +
             std::to_string(size);
    }
  }
  if (!(fx > 0) || !std::isfinite(fx)) return "fx: expected > 0, got " + std::to_string(fx);
  if (!(fy > 0) || !std::isfinite(fy)) return "fy: expected > 0, got " + std::to_string(fy);
  for (const double value : {cx, cy, k1, k2, p1, p2, k3}) {
    if (!std::isfinite(value)) return "expected finite intrinsics";
  }
  return std::nullopt;
}

}  // namespace tagtwist
