#pragma once
#include <cstddef>
#include <vector>

#include "estimator/linear/block_banded.h"

namespace tagtwist::internal {

/// The columns [begin, end) of a matrix that are a piece's own.
struct PieceColumns {
  int begin = 0, end = 0;
};

/// The blocks within the band of the inverse of a long banded matrix, total + (scale - 1) part, of
/// which no more is there at a time than a piece: a few columns that are its own, those before them
/// that reach into these, and as many after them as they reach, whole in the rows up to there.
/// Factorised piece by piece forwards, but for the last one, and then factorised anew and inverted
/// backwards (what Griewank 1992 calls checkpoints).
class ScaledInverse {
 public:
  explicit ScaledInverse(double log_scale) : log_scale_(log_scale) {}

  bool ok() const { return is_ok_; }       // as far as it came that is positive definite
  double trace() const { return trace_; }  // of the inverse times `part`, of the pieces gone back
  /// L in a piece's own columns, into `matrix`. By its number: pieces begin where those before them
  /// ended, and leave what they say of the columns after them.
  void Factorise(const BlockBandedMatrix& total, const BlockBandedMatrix& part, PieceColumns own,
                 size_t number, BlockBandedMatrix* matrix);
  /// The inverse there, in the place of the L that Factorise has just left.
  void InvertBack(const BlockBandedMatrix& part, PieceColumns own, BlockBandedMatrix* matrix);

 private:
  double log_scale_;
  bool is_ok_ = true;
  double trace_ = 0;
  std::vector<BlockBandedMatrix> left_;  // of each piece: of the first columns of the next
  BlockBandedMatrix inverse_after_;      // of the first columns of the piece after
};

}  // namespace tagtwist::internal
