#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/lens/by_coefficients.h"

namespace tagtwist::internal {

/// A number of a lens model.
struct LensCoefficient {
  const char* name;
  double Camera::*value;
};
/// Those of a model, in the order in which files list them.
const std::vector<LensCoefficient>& LensCoefficients(LensModel model);

/// A model's name in files: radtan, equidistant, ds, eucm, omni, fov.
const char* LensName(LensModel model);

/// What the lens makes of normalised coordinates, with the 2 x 2 Jacobian; false (outputs may be
/// anything) where the model has no image of the ray, or has folded.
bool Distort(const Camera& camera, const Eigen::Vector2d& normalised, Eigen::Vector2d* distorted,
             Eigen::Matrix2d* jacobian);

/// The inverse; nullopt where nothing is seen there, or further than 89 degrees off the axis.
std::optional<Eigen::Vector2d> Undistort(const Camera& camera, const Eigen::Vector2d& distorted);

/// Derivatives of the distorted coordinates by the coefficients, for coordinates that Distort has.
ByCoefficients DistortedByCoefficients(const Camera& camera, const Eigen::Vector2d& normalised);

/// The rule that a coefficient breaks.
std::optional<std::string> LensProblem(const Camera& camera);

/// Pixels a unit of normalised coordinates on the axis, along x: fx of the models whose lens does
/// nothing there.
double FocalLengthOnAxis(const Camera& camera);

}  // namespace tagtwist::internal
