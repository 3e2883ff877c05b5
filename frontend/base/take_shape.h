#pragma once
#include <Eigen/Core>

namespace tagtwist::internal {

/// A matrix or vector of any size takes that shape, its values undefined where it had another one.
/// As resize(), but where memory ends it stays as it is: Eigen 3.4 frees the old array before it
/// asks for the new one, and then frees it again.
template <typename Matrix>
void TakeShape(Eigen::Index rows, Eigen::Index columns, Matrix* out) {
  if (out->rows() != rows || out->cols() != columns) *out = Matrix(rows, columns);
}

}  // namespace tagtwist::internal
