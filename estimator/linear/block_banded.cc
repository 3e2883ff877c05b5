#include "estimator/linear/block_banded.h"

#include <algorithm>
#include <utility>

#include "estimator/linear/block_kernels.h"

namespace tagtwist::internal {
namespace {

using Block = BlockBandedMatrix::Block;

// Last block row that column j reaches.
int LastRow(const BlockBandedMatrix& m, int j) { return std::min(m.size() - 1, j + m.bandwidth()); }

}  // namespace

int FactorColumns(int from, int to, BlockBandedMatrix* matrix) {
  BlockBandedMatrix& l = *matrix;
  for (int j = from; j < to; ++j) {
    const Block& l_jj = l.At(j, j);
    if (!FactorInPlace(&l.At(j, j))) return j;
    for (int i = j + 1; i <= LastRow(l, j); ++i) SolveRightTransposed(l_jj, &l.At(i, j));
    for (int k = j + 1; k <= LastRow(l, j); ++k) {
      AddSquare(-1, l.At(k, j), &l.At(k, k));
      for (int i = k + 1; i <= LastRow(l, j); ++i) {
        SubtractProductTransposed(l.At(i, j), l.At(k, j), &l.At(i, k));
      }
    }
  }
  return -1;
}

void SolveForward(const BlockBandedMatrix& l, int from, int to, Eigen::VectorXd* x) {
  const auto part = [x](int j) { return x->segment<kBlockSize>(kBlockSize * j); };
  for (int j = from; j < to; ++j) {
    const BlockVector x_j = Solved(l.At(j, j), part(j));
    part(j) = x_j;
    for (int i = j + 1; i <= LastRow(l, j); ++i) part(i) -= l.At(i, j).lazyProduct(x_j);
  }
}

void SolveBackward(const BlockBandedMatrix& l, int from, int to, Eigen::VectorXd* x) {
  const auto part = [x](int j) { return x->segment<kBlockSize>(kBlockSize * j); };
  for (int j = to - 1; j >= from; --j) {
    BlockVector x_j = part(j);
    for (int i = j + 1; i <= LastRow(l, j); ++i) {
      x_j -= l.At(i, j).transpose().lazyProduct(part(i));
    }
    part(j) = SolvedTransposed(l.At(j, j), x_j);
  }
}

// From the last column to the first: each needs its own part of L, and of the inverse what lies
// beyond it, so that the inverse can take L's place.
void InvertColumns(int from, int to, BlockBandedMatrix* matrix) {
  BlockBandedMatrix& p = *matrix;
  std::vector<Block> g;  // L_kj L_jj^-1, k = j+1...
  for (int j = to - 1; j >= from; --j) {
    const int last = LastRow(p, j);
    const Block l_jj = p.At(j, j);
    g.clear();
    for (int k = j + 1; k <= last; ++k) {
      g.push_back(p.At(k, j));
      SolveRight(l_jj, &g.back());
    }
    Block& p_jj = p.At(j, j);
    p_jj = InverseOf(l_jj);
    for (int i = j + 1; i <= last; ++i) {
      Block& p_ij = p.At(i, j);
      p_ij.setZero();
      for (int k = j + 1; k <= last; ++k) {
        const Block& g_k = g[static_cast<size_t>(k - j - 1)];
        SubtractProduct(i >= k ? p.At(i, k) : Block(p.At(k, i).transpose()), g_k, &p_ij);
      }
      SubtractProduct(p_ij.transpose(), g[static_cast<size_t>(i - j - 1)], &p_jj);
    }
    p_jj = (0.5 * (p_jj + p_jj.transpose())).eval();
  }
}

BlockBandedCholesky::BlockBandedCholesky(BlockBandedMatrix matrix) : l_(std::move(matrix)) {
  failed_at_ = FactorColumns(0, l_.size(), &l_);
}

Eigen::VectorXd BlockBandedCholesky::Solve(const Eigen::VectorXd& b) const {
  Eigen::VectorXd x = b;
  SolveForward(l_, 0, l_.size(), &x);
  SolveBackward(l_, 0, l_.size(), &x);
  return x;
}

BlockBandedMatrix TakeMemory(std::optional<BlockBandedCholesky>* cholesky) {
  BlockBandedMatrix out;
  if (*cholesky) out = std::move((*cholesky)->l_);
  cholesky->reset();
  return out;
}

double BlockBandedCholesky::LogDeterminant() const {
  double sum = 0;
  for (int j = 0; j < l_.size(); ++j) sum += l_.At(j, j).diagonal().array().log().sum();
  return 2 * sum;
}

BlockBandedMatrix BlockBandedCholesky::Inverted() && {
  BlockBandedMatrix p = std::move(l_);
  InvertColumns(0, p.size(), &p);
  return p;
}

}  // namespace tagtwist::internal
