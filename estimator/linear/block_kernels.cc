#include "estimator/linear/block_kernels.h"

#include <cmath>

namespace tagtwist::internal {
namespace {

// Of a triangle's columns from this one on, only the rows from there on are worked on.
constexpr int kHalf = 8;

// Columns [first, last) of the factor, whose rows above kRow are zero or to be.
template <int kRow>
bool FactorColumns(int first, int last, Block* a) {
  using Part = Eigen::Matrix<double, kBlockSize - kRow, 1>;
  for (int j = first; j < last; ++j) {
    Part column = a->col(j).tail<kBlockSize - kRow>();
    for (int k = 0; k < j; ++k) column -= (*a)(j, k) * a->col(k).tail<kBlockSize - kRow>();
    const double pivot = column(j - kRow);
    if (!(pivot > 0)) return false;
    column *= 1 / std::sqrt(pivot);
    a->col(j).tail<kBlockSize - kRow>() = column;
    a->col(j).head(j).setZero();
  }
  return true;
}

// Columns [first, last) of c -= a a', from row kRow on.
template <int kRow>
void SubtractSquareColumns(int first, int last, const Block& a, Block* c) {
  using Part = Eigen::Matrix<double, kBlockSize - kRow, 1>;
  for (int j = first; j < last; ++j) {
    Part sum = c->col(j).tail<kBlockSize - kRow>();
    for (int k = 0; k < kBlockSize; ++k) sum -= a(j, k) * a.col(k).tail<kBlockSize - kRow>();
    c->col(j).tail<kBlockSize - kRow>() = sum;
  }
}

}  // namespace

void SubtractProduct(const Block& a, const Block& b, Block* c) {
  for (int j = 0; j < kBlockSize; ++j) {
    BlockVector sum = c->col(j);
    for (int k = 0; k < kBlockSize; ++k) sum -= b(k, j) * a.col(k);
    c->col(j) = sum;
  }
}

void SubtractProductTransposed(const Block& a, const Block& b, Block* c) {
  for (int j = 0; j < kBlockSize; ++j) {
    BlockVector sum = c->col(j);
    for (int k = 0; k < kBlockSize; ++k) sum -= b(j, k) * a.col(k);
    c->col(j) = sum;
  }
}

void SubtractSquare(const Block& a, Block* c) {
  SubtractSquareColumns<0>(0, kHalf, a, c);
  SubtractSquareColumns<kHalf>(kHalf, kBlockSize, a, c);
}

bool FactorInPlace(Block* a) {
  return FactorColumns<0>(0, kHalf, a) && FactorColumns<kHalf>(kHalf, kBlockSize, a);
}

void SolveRightTransposed(const Block& l, Block* x) {
  for (int j = 0; j < kBlockSize; ++j) {
    BlockVector column = x->col(j);
    for (int k = 0; k < j; ++k) column -= l(j, k) * x->col(k);
    x->col(j) = (1 / l(j, j)) * column;
  }
}

void SolveRight(const Block& l, Block* x) {
  for (int j = kBlockSize - 1; j >= 0; --j) {
    BlockVector column = x->col(j);
    for (int k = j + 1; k < kBlockSize; ++k) column -= l(k, j) * x->col(k);
    x->col(j) = (1 / l(j, j)) * column;
  }
}

Block InverseOf(const Block& l) {
  Block root = Block::Identity();  // L'^-1, upper triangular
  SolveRightTransposed(l, &root);
  Block out;
  for (int j = 0; j < kBlockSize; ++j) {
    BlockVector sum = BlockVector::Zero();
    for (int k = j; k < kBlockSize; ++k) sum += root(j, k) * root.col(k);
    out.col(j) = sum;
  }
  return out;
}

BlockVector Solved(const Block& l, const BlockVector& x) {
  BlockVector rest = x, out;
  for (int j = 0; j < kBlockSize; ++j) {
    out(j) = rest(j) * (1 / l(j, j));
    rest -= out(j) * l.col(j);
  }
  return out;
}

BlockVector SolvedTransposed(const Block& l, const BlockVector& x) {
  BlockVector out = BlockVector::Zero();
  for (int j = kBlockSize - 1; j >= 0; --j) out(j) = (x(j) - l.col(j).dot(out)) * (1 / l(j, j));
  return out;
}

}  // namespace tagtwist::internal
