#include "residuals/lens.h"

#include <cmath>

namespace tagtwist {
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

Eigen::Matrix2Xd PixelByLens(const Camera& camera, const Eigen::Vector3d& point_in_cam) {
  constexpr double kStep = 1e-4;
  Eigen::Matrix2Xd out = Eigen::Matrix2Xd::Zero(2, LensSize(camera));
  Eigen::Vector2d pixel;
  if (!camera.Project(point_in_cam, &pixel)) return out;
  out.col(kLogFocal) << pixel.x() - camera.cx, pixel.y() - camera.cy;
  out(1, kLogAspect) = pixel.y() - camera.cy;
  out(0, kCentreX) = 1;
  out(1, kCentreY) = 1;
  Camera moved = camera;
  const std::vector<Coefficient> distortion = Distortion(&moved);
  for (size_t i = 0; i < distortion.size(); ++i) {
    const double at = *distortion[i].value;
    Eigen::Vector2d above, below;
    *distortion[i].value = at + kStep;
    const bool has_above = moved.Project(point_in_cam, &above);
    *distortion[i].value = at - kStep;
    const bool has_below = moved.Project(point_in_cam, &below);
    *distortion[i].value = at;
    if (!has_above || !has_below) continue;
    out.col(kFirstDistortion + static_cast<Eigen::Index>(i)) = (above - below) / (2 * kStep);
  }
  return out;
}

}  // namespace tagtwist
