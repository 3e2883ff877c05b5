#pragma once
#include <Eigen/Core>

namespace tagtwist::internal {

/// What makes errors of a tag's four corners, (x, y) corner after corner, independent and of unit
/// variance: W upper triangular, W'W = inverse of their covariance [px^2]. Diagonal where the
/// covariance is.
Eigen::Matrix<double, 8, 8> CornerWhitener(const Eigen::Matrix<double, 8, 8>& covariance);

}  // namespace tagtwist::internal
