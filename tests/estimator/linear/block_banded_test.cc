#include "estimator/linear/block_banded.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tagtwist::internal::block_banded_test {
namespace {

constexpr int kSize = BlockBandedMatrix::kSize;

struct Both {
  BlockBandedMatrix banded;
  Eigen::MatrixXd dense;
};

// A random positive definite matrix of the shape.
Both RandomMatrix(int size, int bandwidth, unsigned seed) {
  std::srand(seed);
  Both out{BlockBandedMatrix(size, bandwidth), Eigen::MatrixXd::Zero(kSize * size, kSize * size)};
  for (int j = 0; j < size; ++j) {
    const int rows = std::min(size - j, bandwidth + 1);
    const Eigen::MatrixXd a = Eigen::MatrixXd::Random(kSize * rows, kSize * rows);
    out.dense.block(kSize * j, kSize * j, kSize * rows, kSize * rows) += a * a.transpose();
  }
  for (int j = 0; j < size; ++j) {
    for (int i = j; i < std::min(size, j + bandwidth + 1); ++i) {
      out.banded.At(i, j) = out.dense.block<kSize, kSize>(kSize * i, kSize * j);
    }
  }
  return out;
}

class BlockBanded : public testing::TestWithParam<int> {};

TEST_P(BlockBanded, SolvesAndInvertsLikeADenseMatrix) {
  const int bandwidth = GetParam();
  const Both m = RandomMatrix(7, bandwidth, 5);
  const BlockBandedCholesky cholesky(m.banded);
  ASSERT_TRUE(cholesky.ok());
  const Eigen::VectorXd b = Eigen::VectorXd::Random(7 * kSize);
  const Eigen::MatrixXd inverse = m.dense.inverse();
  EXPECT_LT((cholesky.Solve(b) - inverse * b).norm(), 1e-9 * (inverse * b).norm());
  EXPECT_NEAR(cholesky.LogDeterminant(), std::log(m.dense.determinant()), 1e-8);
  const BlockBandedMatrix selected = cholesky.SelectedInverse();
  for (int j = 0; j < 7; ++j) {
    for (int i = j; i < std::min(7, j + bandwidth + 1); ++i) {
      EXPECT_LT((selected.At(i, j) - inverse.block<kSize, kSize>(kSize * i, kSize * j)).norm(),
                1e-9 * inverse.norm())
          << i << " " << j;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Bandwidths, BlockBanded, testing::Values(0, 1, 3, 6));

TEST(BlockBandedCholesky, TellsAnIndefiniteMatrix) {
  Both m = RandomMatrix(4, 1, 6);
  m.banded.At(2, 2).diagonal().array() -= 1e3;
  EXPECT_FALSE(BlockBandedCholesky(m.banded).ok());
}

}  // namespace
}  // namespace tagtwist::internal::block_banded_test
