// The models whose bend is a polynomial, or a quotient of two.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "frontend/types/lens/lens_models.h"

namespace tagtwist::internal {
namespace {

constexpr int kMaxNewtonSteps = 50;
constexpr double kNewtonDone = 1e-14, kNewtonWorst = 1e-9;

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

ByCoefficients ByRadialTangential(const Camera& c, const Eigen::Vector2d& n) {
  const double x = n.x(), y = n.y(), r2 = n.squaredNorm(), r4 = r2 * r2, r6 = r4 * r2;
  const double below = 1 + c.k4 * r2 + c.k5 * r4 + c.k6 * r6;
  const double radial = (1 + c.k1 * r2 + c.k2 * r4 + c.k3 * r6) / below;
  const Eigen::Vector2d above = n / below, minus = -radial * above;
  ByCoefficients out(2, 8);
  out << r2 * above, r4 * above, Eigen::Vector2d(2 * x * y, r2 + 2 * y * y),
      Eigen::Vector2d(r2 + 2 * x * x, 2 * x * y), r6 * above, r2 * minus, r4 * minus, r6 * minus;
  return out;
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

ByCoefficients ByEquidistant(const Camera& /*camera*/, const Eigen::Vector2d& n) {
  const double r = n.norm(), theta = std::atan(r), t2 = theta * theta;
  ByCoefficients out(2, 4);
  double power = (r > 0 ? theta / r : 1) * t2;
  for (int i = 0; i < 4; ++i, power *= t2) out.col(i) = power * n;
  return out;
}

}  // namespace

LensFunctions RadialTangentialLens() {
  return {DistortRadialTangential, UndistortRadialTangential, ByRadialTangential};
}
LensFunctions EquidistantLens() {
  return {DistortEquidistant, UndistortEquidistant, ByEquidistant};
}

}  // namespace tagtwist::internal
