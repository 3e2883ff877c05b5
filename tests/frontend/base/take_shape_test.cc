#include "frontend/base/take_shape.h"

#include <gtest/gtest.h>

#include <new>

namespace tagtwist::internal::take_shape_test {
namespace {

TEST(TakeShape, OfAMatrixAndAVector) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Ones(2, 3);
  TakeShape(4, 5, &matrix);
  EXPECT_EQ(matrix.rows(), 4);
  EXPECT_EQ(matrix.cols(), 5);
  Eigen::VectorXd vector;
  TakeShape(7, 1, &vector);
  EXPECT_EQ(vector.size(), 7);
  const double* before = vector.data();
  TakeShape(7, 1, &vector);
  EXPECT_EQ(vector.data(), before);
}

// Eigen's resize() would leave an array that is freed a second time here. Slow: where that much is
// asked for sanitizers end the process.
TEST(SlowTakeShape, WhereMemoryEndsTheMatrixStays) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Ones(2, 3);
  constexpr Eigen::Index kTooMany = Eigen::Index{1} << 44;
  EXPECT_THROW(TakeShape(kTooMany, 1, &matrix), std::bad_alloc);
  EXPECT_EQ(matrix, Eigen::MatrixXd(Eigen::MatrixXd::Ones(2, 3)));
}

}  // namespace
}  // namespace tagtwist::internal::take_shape_test
