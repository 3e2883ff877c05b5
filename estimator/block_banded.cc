#include "estimator/block_banded.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace tagtwist {
namespace {

using Block = BlockBandedMatrix::Block;
constexpr int kSize = BlockBandedMatrix::kSize;

// Last block row that column j reaches.
int LastRow(const BlockBandedMatrix& m, int j) { return std::min(m.size() - 1, j + m.bandwidth()); }

}  // namespace

BlockBandedCholesky::BlockBandedCholesky(BlockBandedMatrix matrix) : l_(std::move(matrix)) {
  for (int j = 0; j < l_.size(); ++j) {
    const Eigen::LLT<Block> llt(l_.At(j, j));
    if (llt.info() != Eigen::Success) {
      ok_ = false;
      return;
    }
    l_.At(j, j) = llt.matrixL();
    const Block upper = l_.At(j, j).transpose();
    for (int i = j + 1; i <= LastRow(l_, j); ++i) {
      upper.triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(l_.At(i, j));
    }
    for (int k = j + 1; k <= LastRow(l_, j); ++k) {
      for (int i = k; i <= LastRow(l_, j); ++i) {
        l_.At(i, k).noalias() -= l_.At(i, j) * l_.At(k, j).transpose();
      }
    }
  }
}

Eigen::VectorXd BlockBandedCholesky::Solve(const Eigen::VectorXd& b) const {
  Eigen::VectorXd x = b;
  for (int j = 0; j < l_.size(); ++j) {
    auto x_j = x.segment<kSize>(kSize * j);
    l_.At(j, j).triangularView<Eigen::Lower>().solveInPlace(x_j);
    for (int i = j + 1; i <= LastRow(l_, j); ++i) {
      x.segment<kSize>(kSize * i).noalias() -= l_.At(i, j) * x_j;
    }
  }
  for (int j = l_.size() - 1; j >= 0; --j) {
    auto x_j = x.segment<kSize>(kSize * j);
    for (int i = j + 1; i <= LastRow(l_, j); ++i) {
      x_j.noalias() -= l_.At(i, j).transpose() * x.segment<kSize>(kSize * i);
    }
    l_.At(j, j).transpose().triangularView<Eigen::Upper>().solveInPlace(x_j);
  }
  return x;
}

double BlockBandedCholesky::LogDeterminant() const {
  double sum = 0;
  for (int j = 0; j < l_.size(); ++j) sum += l_.At(j, j).diagonal().array().log().sum();
  return 2 * sum;
}

// From the last column to the first: each needs its own part of L, and of the inverse what lies
// beyond it, so that the inverse can take L's place.
BlockBandedMatrix BlockBandedCholesky::Inverted() && {
  BlockBandedMatrix p = std::move(l_);
  std::vector<Block, Eigen::aligned_allocator<Block>> g;  // L_kj L_jj^-1, k = j+1...
  for (int j = p.size() - 1; j >= 0; --j) {
    const int last = LastRow(p, j);
    const Block l_jj = p.At(j, j);
    const auto diagonal = l_jj.triangularView<Eigen::Lower>();
    g.clear();
    for (int k = j + 1; k <= last; ++k) {
      g.push_back(p.At(k, j));
      diagonal.solveInPlace<Eigen::OnTheRight>(g.back());
    }
    for (int i = j + 1; i <= last; ++i) {
      Block& p_ij = p.At(i, j);
      p_ij.setZero();
      for (int k = j + 1; k <= last; ++k) {
        const Block& g_k = g[static_cast<size_t>(k - j - 1)];
        if (i >= k) {
          p_ij.noalias() -= p.At(i, k) * g_k;
        } else {
          p_ij.noalias() -= p.At(k, i).transpose() * g_k;
        }
      }
    }
    Block inverse = Block::Identity();
    diagonal.solveInPlace(inverse);
    Block& p_jj = p.At(j, j);
    p_jj.noalias() = inverse.transpose() * inverse;
    for (int k = j + 1; k <= last; ++k) {
      p_jj.noalias() -= p.At(k, j).transpose() * g[static_cast<size_t>(k - j - 1)];
    }
    p_jj = (0.5 * (p_jj + p_jj.transpose())).eval();
  }
  return p;
}

}  // namespace tagtwist
