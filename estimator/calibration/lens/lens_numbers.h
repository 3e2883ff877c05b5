#pragma once
#include <string>
#include <vector>

#include "estimator/calibration/lens/lens_from_nothing.h"

namespace tagtwist::internal {

/// What is known of one number of a lens.
struct LensNumber {
  std::string name, unit;  // "fx", "px"
  double value = 0;
  double sigma = 0;  // with LensFound::inflation
};
/// Focal lengths, centre, coefficients; the line time where it was refined.
std::vector<LensNumber> NumbersOf(const LensFound& found);

}  // namespace tagtwist::internal
