#pragma once
#include <Eigen/Core>

namespace tagtwist::internal {

constexpr int kMostLensCoefficients = 8;

/// Derivatives of distorted coordinates by a lens' coefficients, 2 x n.
using ByCoefficients =
    Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, kMostLensCoefficients>;

}  // namespace tagtwist::internal
