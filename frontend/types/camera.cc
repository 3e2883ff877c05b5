#include "frontend/types/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "frontend/base/number_text.h"

namespace tagtwist {

using namespace internal;
namespace {

constexpr double kMinDepthM = 1e-3;
constexpr int kMaxImageSide = 16384;  // [px]
constexpr double kMostFocalLengthPx = 1e6;

constexpr double kLeastStretch = 1e-6;      // of the lens; less is its fold
constexpr double kMostAngleRad = 1.553343;  // 89 degrees
constexpr int kMaxNewtonSteps = 50;
constexpr double kNewtonDone = 1e-14, kNewtonWorst = 1e-9;

// Both models of LensModel: distorted normalised coordinates and their 2x2 Jacobian; false past
// the fold.
bool DistortRadialTangential(const Camera& c, const Eigen::Vector2d& n, Eigen::Vector2d* distorted,
                             Eigen::Matrix2d* jacobian) {
  const double x = n.x(), y = n.y(), r2 = x * x + y * y;
  const double below = 1 + r2 * (c.k4 + r2 * (c.k5 + r2 * c.k6));
  if (!(below > 0)) return false;
  const double radial = (1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3))) / below;
  const double d_radial_d_r2 =
      (c.k1 + r2 * (2 * c.k2 + r2 * 3 * c.k3) - radial * (c.k4 + r2 * (2 * c.k5 + r2 * 3 * c.k6))) /
      below;
  const double cross = 2 * x * y * d_radial_d_r2 + 2 * c.p1 * x + 2 * c.p2 * y;
  *jacobian << radial + 2 * x * x * d_radial_d_r2 + 2 * c.p1 * y + 6 * c.p2 * x, cross, cross,
      radial + 2 * y * y * d_radial_d_r2 + 6 * c.p1 * y + 2 * c.p2 * x;
  *distorted << x * radial + 2 * c.p1 * x * y + c.p2 * (r2 + 2 * x * x),
      y * radial + c.p1 * (r2 + 2 * y * y) + 2 * c.p2 * x * y;
  return radial > 0 && jacobian->determinant() > kLeastStretch;
}

// theta (1 + k1 theta^2 + ...) and its derivative.
double BendAngle(const Camera& c, double theta, double* derivative) {
  const double t2 = theta * theta;
  *derivative = 1 + t2 * (3 * c.k1 + t2 * (5 * c.k2 + t2 * (7 * c.k3 + t2 * 9 * c.k4)));
  return theta * (1 + t2 * (c.k1 + t2 * (c.k2 + t2 * (c.k3 + t2 * c.k4))));
}

bool DistortEquidistant(const Camera& c, const Eigen::Vector2d& n, Eigen::Vector2d* distorted,
                        Eigen::Matrix2d* jacobian) {
  const double r = n.norm();
  double slope = 1;
  const double bent = BendAngle(c, std::atan(r), &slope);
  if (!(slope > kLeastStretch) || !(bent >= 0)) return false;
  *jacobian = Eigen::Matrix2d::Identity();
  *distorted = n;
  constexpr double kAxis = 1e-8;  // nearer the axis the lens does nothing
  if (r < kAxis) return true;
  const double scale = bent / r;
  *distorted = scale * n;
  const double d_scale_d_r = (slope / (1 + r * r) - scale) / r;
  *jacobian = scale * Eigen::Matrix2d::Identity() + (d_scale_d_r / r) * n * n.transpose();
  return true;
}

bool Distort(const Camera& c, const Eigen::Vector2d& n, Eigen::Vector2d* distorted,
             Eigen::Matrix2d* jacobian) {
  return c.lens == LensModel::kEquidistant ? DistortEquidistant(c, n, distorted, jacobian)
                                           : DistortRadialTangential(c, n, distorted, jacobian);
}

// False when the lens folds on the way from its axis to n: beyond, another ray may have the pixel.
bool IsOnFirstBranch(const Camera& c, const Eigen::Vector2d& n) {
  constexpr int kSteps = 16;
  Eigen::Vector2d image;
  Eigen::Matrix2d jacobian;
  for (int i = 1; i < kSteps; ++i) {
    const Eigen::Vector2d between = (static_cast<double>(i) / kSteps) * n;
    if (!DistortRadialTangential(c, between, &image, &jacobian)) return false;
  }
  return true;
}

std::optional<Eigen::Vector2d> UndistortRadialTangential(const Camera& c,
                                                         const Eigen::Vector2d& distorted) {
  Eigen::Vector2d normalised = distorted, image;
  Eigen::Matrix2d jacobian;
  double error = 1;
  for (int i = 0; i < kMaxNewtonSteps && error > kNewtonDone; ++i) {
    if (!DistortRadialTangential(c, normalised, &image, &jacobian)) return std::nullopt;
    const Eigen::Vector2d miss = distorted - image;
    normalised += jacobian.inverse() * miss;
    error = miss.norm();
  }
  if (!(error < kNewtonWorst) || !IsOnFirstBranch(c, normalised)) return std::nullopt;
  return normalised;
}

std::optional<Eigen::Vector2d> UndistortEquidistant(const Camera& c,
                                                    const Eigen::Vector2d& distorted) {
  const double bent = distorted.norm();
  double theta = std::min(bent, kMostAngleRad), error = 1;
  for (int i = 0; i < kMaxNewtonSteps && error > kNewtonDone; ++i) {
    double slope = 1;
    const double miss = bent - BendAngle(c, theta, &slope);
    if (!(slope > kLeastStretch)) return std::nullopt;
    theta += miss / slope;
    error = std::abs(miss);
  }
  if (!(error < kNewtonWorst) || !(theta >= 0 && theta < kMostAngleRad)) return std::nullopt;
  return bent > 0 ? Eigen::Vector2d(std::tan(theta) / bent * distorted) : distorted;
}

}  // namespace

bool Camera::Project(const Eigen::Vector3d& point_in_cam, Eigen::Vector2d* pixel,
                     Eigen::Matrix<double, 2, 3>* d_pixel_d_point) const {
  if (!(point_in_cam.z() >= kMinDepthM)) return false;
  const double iz = 1.0 / point_in_cam.z();
  const Eigen::Vector2d normalised = point_in_cam.head<2>() * iz;
  Eigen::Matrix2d d_distorted = Eigen::Matrix2d::Identity();
  Eigen::Vector2d distorted = normalised;
  if (IsDistorted() && !Distort(*this, normalised, &distorted, &d_distorted)) return false;
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
  std::optional<Eigen::Vector2d> normalised = distorted;
  Eigen::Matrix2d jacobian = Eigen::Matrix2d::Identity();
  if (IsDistorted()) {
    normalised = lens == LensModel::kEquidistant ? UndistortEquidistant(*this, distorted)
                                                 : UndistortRadialTangential(*this, distorted);
    Eigen::Vector2d again;
    if (!normalised || !Distort(*this, *normalised, &again, &jacobian)) return std::nullopt;
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
  for (const auto& [key, length] : {std::pair("fx", fx), std::pair("fy", fy)}) {
    if (!(length > 0)) return std::string(key) + ": expected > 0, got " + FormatNumber(length);
    if (length <= kMostFocalLengthPx) continue;
    return std::string(key) + ": expected at most 1e6 px, got " + FormatNumber(length);
  }
  for (const double value : {cx, cy, k1, k2, p1, p2, k3, k4, k5, k6}) {
    if (!std::isfinite(value)) return "expected finite intrinsics";
  }
  return std::nullopt;
}

}  // namespace tagtwist
