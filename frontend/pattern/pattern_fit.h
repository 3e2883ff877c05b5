#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>

#include "frontend/pattern/pattern_state.h"
#include "frontend/pattern/pattern_sums.h"

namespace tagtwist::internal {

/// Where a fit starts.
struct PatternStart {
  std::array<Eigen::Vector2d, 4> corners;  // p1..p4 [px], off by about half a cell at most
  /// Without it: a usual blur, greys from the pixels. With it the corners are to be within 0.5 px,
  /// the fit may end at its first iteration, and one that many pixels contradict at once is given
  /// up.
  std::optional<PatternLook> look;
  bool rough = false;  // with a look: the corners are off by more than a tenth of a pixel
};

/// A pattern aligned to an image.
struct PatternFit {
  PatternState state;
  std::array<Eigen::Vector2d, 4> corners;  // p1..p4 [px]
  Eigen::Matrix<double, 8, 8> covariance;  // u1 v1 .. u4 v4 [px^2]
  double noise_grey = 0;                   // robust standard deviation of the residuals [grey]
  double inlier_share = 0;                 // mean weight of the pixels, 0 to 1
  double contradicted_share = 0;           // pixels that are off by more than half the contrast
  int iterations = 0;
};

/// Gauss-Newton over the unknowns of PatternState. Tukey's weights, their scale from the median
/// residual, keep out what hides a part of the tag. Covariance: the inverse normal matrix with
/// blur, greys and light marginalised, times the variance of the residuals (of an M-estimator:
/// mean psi^2 / mean psi'^2). nullopt when it does not converge or has no contrast.
std::optional<PatternFit> FitPattern(const PatternModel& model, const NormalTable& normal,
                                     const PatternPixels& pixels, const PatternStart& start);

}  // namespace tagtwist::internal
