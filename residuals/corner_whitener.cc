#include "residuals/corner_whitener.h"

#include <Eigen/Cholesky>

namespace tagtwist::internal {

Eigen::Matrix<double, 8, 8> CornerWhitener(const Eigen::Matrix<double, 8, 8>& covariance) {
  using Matrix8 = Eigen::Matrix<double, 8, 8>;
  if (covariance.isDiagonal(0))
    return covariance.diagonal().cwiseSqrt().cwiseInverse().asDiagonal();
  // Reversed, the Cholesky factor of the covariance is upper triangular, and so is its inverse.
  const Eigen::LLT<Matrix8> reversed(covariance.reverse());
  return reversed.matrixL().solve(Matrix8::Identity()).reverse();
}

}  // namespace tagtwist::internal
