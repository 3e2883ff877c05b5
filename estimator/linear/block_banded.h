#pragma once
#include <Eigen/Core>
#include <Eigen/StdVector>
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
    blocks_.assign(static_cast<size_t>(size) * static_cast<size_t>(bandwidth + 1), Block::Zero());
  }

  int size() const { return size_; }            // blocks a side
  int bandwidth() const { return bandwidth_; }  // blocks below the diagonal
  /// Block (row, column), column <= row <= column + bandwidth.
  Block& At(int row, int column) { return blocks_[Index(row, column)]; }
  const Block& At(int row, int column) const { return blocks_[Index(row, column)]; }

 private:
  size_t Index(int row, int column) const {
    return static_cast<size_t>(column) * static_cast<size_t>(bandwidth_ + 1) +
           static_cast<size_t>(row - column);
  }
  int size_ = 0, bandwidth_ = 0;
  std::vector<Block, Eigen::aligned_allocator<Block>> blocks_;
};

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
