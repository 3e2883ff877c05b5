#pragma once
#include <Eigen/Core>
#include <optional>

#include "frontend/types/camera.h"
#include "frontend/types/lens/by_coefficients.h"

namespace tagtwist::internal {

constexpr double kLeastStretch = 1e-6;      // of a lens; less is its fold
constexpr double kMostAngleRad = 1.553343;  // 89 degrees

/// Each model's Distort, Undistort and DistortedByCoefficients (lens.h).
struct LensFunctions {
  bool (*distort)(const Camera&, const Eigen::Vector2d&, Eigen::Vector2d*, Eigen::Matrix2d*);
  std::optional<Eigen::Vector2d> (*undistort)(const Camera&, const Eigen::Vector2d&);
  ByCoefficients (*by_coefficients)(const Camera&, const Eigen::Vector2d&);
};
LensFunctions RadialTangentialLens();
LensFunctions EquidistantLens();
LensFunctions DoubleSphereLens();
LensFunctions ExtendedUnifiedLens();
LensFunctions OmniLens();
LensFunctions FieldOfViewLens();

}  // namespace tagtwist::internal
