#include "estimator/linear/block_banded.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "estimator/linear/scaled_inverse.h"

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

// The piece's own columns, those that reach into them and those that they reach, as a matrix.
BlockBandedMatrix Cut(const BlockBandedMatrix& m, int first, int last) {
  BlockBandedMatrix out(last - first, std::min(last - first - 1, m.bandwidth()));
  for (int j = 0; j < out.size(); ++j) {
    for (int i = j; i <= std::min(out.size() - 1, j + out.bandwidth()); ++i) {
      out.At(i, j) = m.At(first + i, first + j);
    }
  }
  return out;
}

// Pieces of four columns and a shorter one, which for the widest band are shorter than what reaches
// into the next.
TEST_P(BlockBanded, IsInvertedInPiecesLikeADenseMatrix) {
  constexpr int kLength = 4, kColumns = 11;
  const int bandwidth = GetParam();
  const Both total = RandomMatrix(kColumns, bandwidth, 5), part = RandomMatrix(kColumns, 0, 6);
  const double more = std::exp(0.3) - 1;
  const Eigen::MatrixXd inverse = (total.dense + more * part.dense).inverse();
  ScaledInverse pieces(0.3);
  BlockBandedMatrix p;
  const auto visit = [&](size_t number, bool is_back) {
    const int begin = kLength * static_cast<int>(number), end = std::min(kColumns, begin + kLength);
    const int first = std::max(0, begin - bandwidth), last = std::min(kColumns, end + bandwidth);
    const BlockBandedMatrix of_total = Cut(total.banded, first, last),
                            of_part = Cut(part.banded, first, last);
    const PieceColumns own{begin - first, end - first};
    pieces.Factorise(of_total, of_part, own, number, &p);
    if (!is_back) return;
    pieces.InvertBack(of_part, own, &p);
    for (int j = own.begin; j < own.end; ++j) {
      for (int i = j; i <= std::min(p.size() - 1, j + bandwidth); ++i) {
        const auto expected = inverse.block<kSize, kSize>(kSize * (first + i), kSize * (first + j));
        EXPECT_LT((p.At(i, j) - expected).norm(), 1e-9 * inverse.norm()) << first + j;
      }
    }
  };
  for (const size_t number : {0, 1}) visit(number, false);
  for (const size_t number : {2, 1, 0}) visit(number, true);
  ASSERT_TRUE(pieces.ok());
  EXPECT_NEAR(pieces.trace(), (inverse * part.dense).trace(), 1e-9 * pieces.trace());
}

TEST(BlockBandedCholesky, TellsAnIndefiniteMatrix) {
  Both m = RandomMatrix(4, 1, 6);
  m.banded.At(2, 2).diagonal().array() -= 1e3;
  EXPECT_FALSE(BlockBandedCholesky(m.banded).ok());
}

}  // namespace
}  // namespace tagtwist::internal::block_banded_test
