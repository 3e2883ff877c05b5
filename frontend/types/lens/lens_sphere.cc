// The models that see over a sphere or an ellipsoid, and the field-of-view model: their inverses
// are closed forms.
#include <cmath>

#include "frontend/types/lens/lens_models.h"

namespace tagtwist::internal {
namespace {

// distorted = scale(r^2) n: the Jacobian; false where the image does not move outwards any more.
bool ScaleRadially(const Eigen::Vector2d& n, double scale, double d_scale_d_r2,
                   Eigen::Vector2d* distorted, Eigen::Matrix2d* jacobian) {
  const double r2 = n.squaredNorm();
  *distorted = scale * n;
  *jacobian = scale * Eigen::Matrix2d::Identity() + 2 * d_scale_d_r2 * n * n.transpose();
  const double by_angle = (scale + 2 * d_scale_d_r2 * r2) * (1 + r2);
  return scale > 0 && std::isfinite(scale) && by_angle > kLeastStretch;
}

// Coordinates of a ray, where it lies before the camera and 89 degrees about its axis.
std::optional<Eigen::Vector2d> Before(const Eigen::Vector2d& across, double along) {
  if (!(along > 0) || !(across.norm() < std::tan(kMostAngleRad) * along)) return std::nullopt;
  return across / along;
}

// That the inverse led to the ray and not to another one with its pixel.
std::optional<Eigen::Vector2d> IfSeenAt(const Camera& c, const LensFunctions& lens,
                                        const std::optional<Eigen::Vector2d>& n,
                                        const Eigen::Vector2d& distorted) {
  Eigen::Vector2d again;
  Eigen::Matrix2d jacobian;
  if (!n || !lens.distort(c, *n, &again, &jacobian)) return std::nullopt;
  return (again - distorted).norm() < 1e-9 * (1 + distorted.norm()) ? n : std::nullopt;
}

// Usenko, Demmel and Cremers 2018, The double sphere camera model, eqs. 40 to 52.
struct DoubleSphere {
  double to_first = 0, after_first = 0, to_second = 0, below = 0;
  DoubleSphere(const Camera& c, double r2)
      : to_first(std::sqrt(1 + r2)),
        after_first(c.xi * to_first + 1),
        to_second(std::sqrt(r2 + after_first * after_first)),
        below(c.alpha * to_second + (1 - c.alpha) * after_first) {}
};

bool DistortDoubleSphere(const Camera& c, const Eigen::Vector2d& n, Eigen::Vector2d* distorted,
                         Eigen::Matrix2d* jacobian) {
  const double r2 = n.squaredNorm();
  const DoubleSphere s(c, r2);
  const double w1 = c.alpha <= 0.5 ? c.alpha / (1 - c.alpha) : (1 - c.alpha) / c.alpha;
  const double w2 = (w1 + c.xi) / std::sqrt(2 * w1 * c.xi + c.xi * c.xi + 1);
  if (!(1 > -w2 * s.to_first) || !(s.below > 0)) return false;
  const double d_after = 0.5 * c.xi / s.to_first;
  const double d_below =
      c.alpha * (0.5 + s.after_first * d_after) / s.to_second + (1 - c.alpha) * d_after;
  return ScaleRadially(n, 1 / s.below, -d_below / (s.below * s.below), distorted, jacobian);
}

std::optional<Eigen::Vector2d> UndistortDoubleSphere(const Camera& c, const Eigen::Vector2d& m) {
  const double r2 = m.squaredNorm(), under = 1 - (2 * c.alpha - 1) * r2;
  if (!(under >= 0)) return std::nullopt;
  const double z = (1 - c.alpha * c.alpha * r2) / (c.alpha * std::sqrt(under) + 1 - c.alpha);
  const double root = z * z + (1 - c.xi * c.xi) * r2;
  if (!(root >= 0)) return std::nullopt;
  const double scale = (z * c.xi + std::sqrt(root)) / (z * z + r2);
  return IfSeenAt(c, DoubleSphereLens(), Before(scale * m, scale * z - c.xi), m);
}

ByCoefficients ByDoubleSphere(const Camera& c, const Eigen::Vector2d& n) {
  const DoubleSphere s(c, n.squaredNorm());
  const double by_xi = s.to_first * (c.alpha * s.after_first / s.to_second + 1 - c.alpha);
  ByCoefficients out(2, 2);
  out.col(0) = -by_xi / (s.below * s.below) * n;
  out.col(1) = -(s.to_second - s.after_first) / (s.below * s.below) * n;
  return out;
}

// Khomutenko, Garcia and Martinet 2016, as Usenko et al. write it, eqs. 17 to 27.
bool DistortExtendedUnified(const Camera& c, const Eigen::Vector2d& n, Eigen::Vector2d* distorted,
                            Eigen::Matrix2d* jacobian) {
  const double root = std::sqrt(1 + c.beta * n.squaredNorm());
  const double below = c.alpha * root + 1 - c.alpha;
  if (!(below > 0)) return false;
  const double d_below = 0.5 * c.alpha * c.beta / root;
  return ScaleRadially(n, 1 / below, -d_below / (below * below), distorted, jacobian);
}

std::optional<Eigen::Vector2d> UndistortExtendedUnified(const Camera& c, const Eigen::Vector2d& m) {
  const double r2 = m.squaredNorm(), under = 1 - (2 * c.alpha - 1) * c.beta * r2;
  if (!(under >= 0)) return std::nullopt;
  const double z =
      (1 - c.beta * c.alpha * c.alpha * r2) / (c.alpha * std::sqrt(under) + 1 - c.alpha);
  return IfSeenAt(c, ExtendedUnifiedLens(), Before(m, z), m);
}

ByCoefficients ByExtendedUnified(const Camera& c, const Eigen::Vector2d& n) {
  const double r2 = n.squaredNorm(), root = std::sqrt(1 + c.beta * r2);
  const double below = c.alpha * root + 1 - c.alpha;
  ByCoefficients out(2, 2);
  out.col(0) = -(root - 1) / (below * below) * n;
  out.col(1) = -0.5 * c.alpha * r2 / root / (below * below) * n;
  return out;
}

// Mei and Rives 2007, Single view point omnidirectional camera calibration from planar grids:
// onto the unit sphere, from a point xi above its centre onto a plane, and there radtan.
bool DistortOmni(const Camera& c, const Eigen::Vector2d& n, Eigen::Vector2d* distorted,
                 Eigen::Matrix2d* jacobian) {
  const double on_sphere = std::sqrt(1 + n.squaredNorm()), below = 1 + c.xi * on_sphere;
  if (!(below > 0)) return false;
  Eigen::Vector2d on_plane;
  Eigen::Matrix2d by_ray, by_plane;
  const double d_scale = -0.5 * c.xi / (on_sphere * below * below);
  if (!ScaleRadially(n, 1 / below, d_scale, &on_plane, &by_ray)) return false;
  if (!RadialTangentialLens().distort(c, on_plane, distorted, &by_plane)) return false;
  *jacobian = by_plane * by_ray;
  return true;
}

std::optional<Eigen::Vector2d> UndistortOmni(const Camera& c, const Eigen::Vector2d& distorted) {
  const auto plane = RadialTangentialLens().undistort(c, distorted);
  if (!plane) return std::nullopt;
  const double r2 = plane->squaredNorm(), under = 1 + (1 - c.xi * c.xi) * r2;
  if (!(under >= 0)) return std::nullopt;
  const double scale = (c.xi + std::sqrt(under)) / (r2 + 1);
  return IfSeenAt(c, OmniLens(), Before(scale * *plane, scale - c.xi), distorted);
}

ByCoefficients ByOmni(const Camera& c, const Eigen::Vector2d& n) {
  const double on_sphere = std::sqrt(1 + n.squaredNorm()), below = 1 + c.xi * on_sphere;
  const Eigen::Vector2d on_plane = n / below;
  Eigen::Vector2d distorted;
  Eigen::Matrix2d by_plane;
  RadialTangentialLens().distort(c, on_plane, &distorted, &by_plane);
  ByCoefficients out(2, 5);
  out.col(0) = by_plane * (-on_sphere / below * on_plane);
  out.rightCols<4>() = RadialTangentialLens().by_coefficients(c, on_plane).leftCols<4>();
  return out;
}

// Devernay and Faugeras 2001, Straight lines have to be straight:
// r' = atan(2 r tan(w / 2)) / w.
constexpr double kNearAxis = 1e-4;  // nearer the axis a series is exact

bool DistortFieldOfView(const Camera& c, const Eigen::Vector2d& n, Eigen::Vector2d* distorted,
                        Eigen::Matrix2d* jacobian) {
  const double r2 = n.squaredNorm(), r = std::sqrt(r2), twice = 2 * std::tan(0.5 * c.w);
  double scale = twice / c.w * (1 - twice * twice * r2 / 3);
  double d_scale = -twice * twice * twice / (3 * c.w);
  if (r > kNearAxis) {
    scale = std::atan(twice * r) / (c.w * r);
    d_scale = 0.5 * (twice / (c.w * (1 + twice * twice * r2)) - scale) / r2;
  }
  return ScaleRadially(n, scale, d_scale, distorted, jacobian);
}

std::optional<Eigen::Vector2d> UndistortFieldOfView(const Camera& c, const Eigen::Vector2d& m) {
  const double bent = m.norm(), angle = bent * c.w;
  if (!(angle < M_PI_2)) return std::nullopt;
  const double twice = 2 * std::tan(0.5 * c.w);
  const double scale = bent > 0 ? std::tan(angle) / (twice * bent) : c.w / twice;
  return IfSeenAt(c, FieldOfViewLens(), Before(scale * m, 1), m);
}

ByCoefficients ByFieldOfView(const Camera& c, const Eigen::Vector2d& n) {
  const double r2 = n.squaredNorm(), r = std::sqrt(r2), tangent = std::tan(0.5 * c.w);
  const double twice = 2 * tangent, d_twice = 1 + tangent * tangent;
  const double angle =
      r > kNearAxis ? std::atan(twice * r) / r : twice * (1 - twice * twice * r2 / 3);
  ByCoefficients out(2, 1);
  out.col(0) = (d_twice / (1 + twice * twice * r2) - angle / c.w) / c.w * n;
  return out;
}

}  // namespace

LensFunctions DoubleSphereLens() {
  return {DistortDoubleSphere, UndistortDoubleSphere, ByDoubleSphere};
}
LensFunctions ExtendedUnifiedLens() {
  return {DistortExtendedUnified, UndistortExtendedUnified, ByExtendedUnified};
}
LensFunctions OmniLens() { return {DistortOmni, UndistortOmni, ByOmni}; }
LensFunctions FieldOfViewLens() {
  return {DistortFieldOfView, UndistortFieldOfView, ByFieldOfView};
}

}  // namespace tagtwist::internal
