#include "residuals/lens.h"

#include <cmath>

namespace tagtwist::internal {
namespace {

struct Coefficient {
  const char* name;
  double* value;
};

// In the order of the configuration.
std::vector<Coefficient> Distortion(Camera* c) {
  if (c->lens == LensModel::kEquidistant) {
    return {{"k1", &c->k1}, {"k2", &c->k2}, {"k3", &c->k3}, {"k4", &c->k4}};
  }
  return {{"k1", &c->k1}, {"k2", &c->k2}, {"p1", &c->p1}, {"p2", &c->p2},
          {"k3", &c->k3}, {"k4", &c->k4}, {"k5", &c->k5}, {"k6", &c->k6}};
}

// Derivatives of the distorted normalised coordinates (camera.h) by the coefficients.
Eigen::Matrix<double, 2, 4> ByEquidistant(const Eigen::Vector2d& n) {
  const double r = n.norm(), theta = std::atan(r), t2 = theta * theta;
  Eigen::Matrix<double, 2, 4> out;
  double power = (r > 0 ? theta / r : 1) * t2;
  for (int i = 0; i < 4; ++i, power *= t2) out.col(i) = power * n;
  return out;
}

Eigen::Matrix<double, 2, 8> ByRadialTangential(const Camera& c, const Eigen::Vector2d& n) {
  const double x = n.x(), y = n.y(), r2 = n.squaredNorm(), r4 = r2 * r2, r6 = r4 * r2;
  const double below = 1 + c.k4 * r2 + c.k5 * r4 + c.k6 * r6;
  const double radial = (1 + c.k1 * r2 + c.k2 * r4 + c.k3 * r6) / below;
  const Eigen::Vector2d above = n / below, minus = -radial * above;
  Eigen::Matrix<double, 2, 8> out;
  out << r2 * above, r4 * above, Eigen::Vector2d(2 * x * y, r2 + 2 * y * y),
      Eigen::Vector2d(r2 + 2 * x * x, 2 * x * y), r6 * above, r2 * minus, r4 * minus, r6 * minus;
  return out;
}

}  // namespace

std::vector<std::string> DistortionNames(Camera camera) {
  std::vector<std::string> out;
  for (const Coefficient& coefficient : Distortion(&camera)) out.emplace_back(coefficient.name);
  return out;
}

Eigen::VectorXd DistortionCoefficients(Camera camera) {
  const std::vector<Coefficient> from = Distortion(&camera);
  Eigen::VectorXd out(static_cast<Eigen::Index>(from.size()));
  for (size_t i = 0; i < from.size(); ++i) out(static_cast<Eigen::Index>(i)) = *from[i].value;
  return out;
}

int LensSize(const Camera& camera) {
  return kFirstDistortion + (camera.lens == LensModel::kEquidistant ? 4 : 8);
}

Camera PerturbLens(const Camera& camera, const Eigen::VectorXd& step) {
  Camera out = camera;
  out.fx *= std::exp(step(kLogFocal));
  out.fy *= std::exp(step(kLogFocal) + step(kLogAspect));
  out.cx += step(kCentreX);
  out.cy += step(kCentreY);
  const std::vector<Coefficient> distortion = Distortion(&out);
  for (size_t i = 0; i < distortion.size(); ++i) {
    *distortion[i].value += step(kFirstDistortion + static_cast<Eigen::Index>(i));
  }
  return out;
}

Eigen::VectorXd LensDifference(const Camera& camera, const Camera& reference) {
  Eigen::VectorXd out(LensSize(camera));
  out(kLogFocal) = std::log(camera.fx / reference.fx);
  out(kLogAspect) = std::log(camera.fy / reference.fy) - out(kLogFocal);
  out(kCentreX) = camera.cx - reference.cx;
  out(kCentreY) = camera.cy - reference.cy;
  out.tail(out.size() - kFirstDistortion) =
      DistortionCoefficients(camera) - DistortionCoefficients(reference);
  return out;
}

LensJacobian PixelByLens(const Camera& camera, const Eigen::Vector3d& point_in_cam,
                         const Eigen::Vector2d& pixel) {
  LensJacobian out(2, LensSize(camera));
  const Eigen::Vector2d normalised = point_in_cam.head<2>() / point_in_cam.z();
  out.col(kLogFocal) << pixel.x() - camera.cx, pixel.y() - camera.cy;
  out.col(kLogAspect) << 0, pixel.y() - camera.cy;
  out.col(kCentreX) << 1, 0;
  out.col(kCentreY) << 0, 1;
  auto distortion = out.rightCols(out.cols() - kFirstDistortion);
  if (camera.lens == LensModel::kEquidistant) {
    distortion = ByEquidistant(normalised);
  } else {
    distortion = ByRadialTangential(camera, normalised);
  }
  distortion = (Eigen::Vector2d(camera.fx, camera.fy).asDiagonal() * distortion).eval();
  return out;
}

}  // namespace tagtwist::internal
