#include "residuals/lens.h"

#include <cmath>

#include "frontend/types/lens/lens.h"

namespace tagtwist::internal {

std::vector<std::string> DistortionNames(const Camera& camera) {
  std::vector<std::string> out;
  for (const LensCoefficient& coefficient : LensCoefficients(camera.lens)) {
    out.emplace_back(coefficient.name);
  }
  return out;
}

Eigen::VectorXd DistortionCoefficients(const Camera& camera) {
  const std::vector<LensCoefficient>& from = LensCoefficients(camera.lens);
  Eigen::VectorXd out(static_cast<Eigen::Index>(from.size()));
  for (size_t i = 0; i < from.size(); ++i) {
    out(static_cast<Eigen::Index>(i)) = camera.*from[i].value;
  }
  return out;
}

int LensSize(const Camera& camera) {
  return kFirstDistortion + static_cast<int>(LensCoefficients(camera.lens).size());
}

Camera PerturbLens(const Camera& camera, const Eigen::VectorXd& step) {
  Camera out = camera;
  out.fx *= std::exp(step(kLogFocal));
  out.fy *= std::exp(step(kLogFocal) + step(kLogAspect));
  out.cx += step(kCentreX);
  out.cy += step(kCentreY);
  const std::vector<LensCoefficient>& distortion = LensCoefficients(camera.lens);
  for (size_t i = 0; i < distortion.size(); ++i) {
    out.*distortion[i].value += step(kFirstDistortion + static_cast<Eigen::Index>(i));
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
  out.rightCols(out.cols() - kFirstDistortion) =
      Eigen::Vector2d(camera.fx, camera.fy).asDiagonal() *
      DistortedByCoefficients(camera, normalised);
  return out;
}

}  // namespace tagtwist::internal
