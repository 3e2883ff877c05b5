#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "estimator/linear/block.h"

namespace tagtwist::internal {

/// Symmetric matrix of n x n blocks of kSize x kSize, zero beyond `bandwidth` blocks from the
/// diagonal; only the lower triangle is kept. The normal equations of a trajectory have this shape
/// once the tracked points are eliminated, so that factorising, solving and inverting within the
/// band all cost O(n bandwidth^2).
class BlockBandedMatrix {
 public:
  static constexpr int kSize = kBlockSize;
  using Block = tagtwist::Block;

  BlockBandedMatrix() = default;
  BlockBandedMatrix(int size, int bandwidth) { SetZero(size, bandwidth); }

  /// A zero matrix of that shape, in the memory of what was here.
  void SetZero(int size, int bandwidth) {
    size_ = size;
    bandwidth_ = bandwidth;
    diagonals_.resize(static_cast<size_t>(bandwidth + 1));
    for (auto& diagonal : diagonals_) diagonal.assign(static_cast<size_t>(size), Block::Zero());
  }

  int size() const { return size_; }            // blocks a side
  int bandwidth() const { return bandwidth_; }  // blocks below the diagonal
  /// Block (row, column), column <= row <= column + bandwidth.
  Block& At(int row, int column) {
    return diagonals_[static_cast<size_t>(row - column)][static_cast<size_t>(column)];
  }
  const Block& At(int row, int column) const {
    return diagonals_[static_cast<size_t>(row - column)][static_cast<size_t>(column)];
  }
  /// The blocks so many below the diagonal, which is 0, from the first column to the last that has
  /// one: without a copy, for the matrix is large. Once each, of a matrix that nobody needs.
  std::vector<Block> TakeDiagonal(int below) {
    std::vector<Block> out = std::move(diagonals_[static_cast<size_t>(below)]);
    out.resize(out.size() - std::min(out.size(), static_cast<size_t>(below)));
    return out;
  }

 private:
  int size_ = 0, bandwidth_ = 0;
  std::vector<std::vector<Block>> diagonals_;  // each with a block a column
};

/// The steps of a factorisation H = L L', of the columns [from, to) alone, whose rows the matrix
/// must have: so that a long matrix can be gone through in pieces that overlap by the bandwidth.
/// L takes H's place there, and what it says of the columns after is taken from them. The first
/// column where H is not positive definite; -1: it is.
int FactorColumns(int from, int to, BlockBandedMatrix* matrix);
/// L^-1 x: the entries of those columns, which leave what they say of the entries after there.
void SolveForward(const BlockBandedMatrix& l, int from, int to, Eigen::VectorXd* x);
/// L'^-1 x, the entries after those columns known.
void SolveBackward(const BlockBandedMatrix& l, int from, int to, Eigen::VectorXd* x);
/// The blocks of H^-1 within the band in the place of L, those of the columns after known.
void InvertColumns(int from, int to, BlockBandedMatrix* matrix);

/// Cholesky factorisation H = L L' of a positive definite BlockBandedMatrix.
class BlockBandedCholesky {
 public:
  explicit BlockBandedCholesky(BlockBandedMatrix matrix);

  /// False when the matrix was not positive definite; then nothing else but failed_at may be
  /// called.
  bool ok() const { return failed_at_ < 0; }
  /// The first block whose rows up to there are not positive definite; -1 where all are.
  int failed_at() const { return failed_at_; }
  /// Solution of H x = b; b has kSize size entries.
  Eigen::VectorXd Solve(const Eigen::VectorXd& b) const;
  /// log det H.
  double LogDeterminant() const;
  /// The blocks of H^-1 within the band: the selected inverse (Takahashi, Fagan and Chin 1973).
  /// That of a temporary takes the place of its factor.
  BlockBandedMatrix SelectedInverse() const& { return BlockBandedCholesky(*this).Inverted(); }
  BlockBandedMatrix SelectedInverse() && { return std::move(*this).Inverted(); }

 private:
  friend BlockBandedMatrix TakeMemory(std::optional<BlockBandedCholesky>* cholesky);
  BlockBandedMatrix Inverted() &&;

  BlockBandedMatrix l_;
  int failed_at_ = -1;
};

/// The matrix of factors that are no longer needed, of any value, to be filled anew; leaves none.
BlockBandedMatrix TakeMemory(std::optional<BlockBandedCholesky>* cholesky);

}  // namespace tagtwist::internal
