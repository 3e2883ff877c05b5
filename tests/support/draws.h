#pragma once
#include <Eigen/Core>

namespace tagtwist::internal {

/// A vector of independent draws, its last component drawn first. An order of its own: in which a
/// call's arguments, say those of Eigen::Vector3d(), are drawn is the compiler's choice, and a test
/// sees other values by another.
template <int kSize, typename Distribution, typename Engine>
Eigen::Matrix<double, kSize, 1> DrawVector(Distribution& distribution, Engine& engine) {
  Eigen::Matrix<double, kSize, 1> out;
  for (int i = kSize - 1; i >= 0; --i) out(i) = distribution(engine);
  return out;
}

}  // namespace tagtwist::internal
