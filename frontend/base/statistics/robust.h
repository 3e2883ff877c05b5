#pragma once
#include <cmath>

namespace tagtwist::internal {

/// What a robust loss makes of a whitened block: its weight in the normal equations, and its cost,
/// which replaces half the sum of squares.
struct RobustLoss {
  double weight = 1, cost = 0;
};

/// Huber's loss (1964) of a block's norm: half the square up to the threshold `delta`, from there
/// on a straight line. 0 as the threshold: half the square everywhere.
inline RobustLoss Huber(double squared_norm, double delta) {
  const double norm = std::sqrt(squared_norm);
  if (!(delta > 0) || !(norm > delta)) return {1, 0.5 * squared_norm};
  return {delta / norm, delta * (norm - 0.5 * delta)};
}

/// The threshold on the norm of a block of that many rows which lies at `scale` root mean squares.
inline double HuberDelta(double scale, int rows) {
  return scale * std::sqrt(static_cast<double>(rows));
}

}  // namespace tagtwist::internal
