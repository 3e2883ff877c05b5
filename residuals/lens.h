#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "frontend/types/camera.h"

namespace tagtwist::internal {

/// Error state of a lens, LensSize() entries: [log focal length (both), log fy/fx, cx [px], cy
/// [px], distortion coefficients in the order of the configuration].
enum LensEntry { kLogFocal = 0, kLogAspect, kCentreX, kCentreY, kFirstDistortion };

/// Names of the lens model's coefficients, "k1", ..., in the order of the configuration.
std::vector<std::string> DistortionNames(const Camera& camera);
/// Their values.
Eigen::VectorXd DistortionCoefficients(const Camera& camera);

int LensSize(const Camera& camera);

/// camera [+] step: focal lengths scaled by the exponentials, the rest added.
Camera PerturbLens(const Camera& camera, const Eigen::VectorXd& step);
/// The inverse: the step from `reference` to `camera`, of one model.
Eigen::VectorXd LensDifference(const Camera& camera, const Camera& reference);

constexpr int kMaxLensSize = 12;
/// Derivative [px] of the pixel of a point that projects, 2 x LensSize.
using LensJacobian = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, kMaxLensSize>;
LensJacobian PixelByLens(const Camera& camera, const Eigen::Vector3d& point_in_cam,
                         const Eigen::Vector2d& pixel);

}  // namespace tagtwist::internal
