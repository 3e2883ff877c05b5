#pragma once
#include "estimator/block_banded.h"

namespace tagtwist {

/// Products and triangular solves of blocks. Column by column, each in registers from its first
/// summand to its last: at this size Eigen's general kernels spend more time on packing and on
/// choosing than on sums. Lower triangular L always has zeros above its diagonal.

/// c -= a b.
void SubtractProduct(const BlockBandedMatrix::Block& a, const BlockBandedMatrix::Block& b,
                     BlockBandedMatrix::Block* c);
/// c -= a b'.
void SubtractProductTransposed(const BlockBandedMatrix::Block& a, const BlockBandedMatrix::Block& b,
                               BlockBandedMatrix::Block* c);
/// c -= a a' in the lower triangle; above it c may take any value.
void SubtractSquare(const BlockBandedMatrix::Block& a, BlockBandedMatrix::Block* c);
/// L L' = a in a's place, of which only the lower triangle is read; false where it is not positive
/// definite.
bool FactorInPlace(BlockBandedMatrix::Block* a);
/// x = x L'^-1.
void SolveRightTransposed(const BlockBandedMatrix::Block& l, BlockBandedMatrix::Block* x);
/// x = x L^-1.
void SolveRight(const BlockBandedMatrix::Block& l, BlockBandedMatrix::Block* x);
/// (L L')^-1.
BlockBandedMatrix::Block InverseOf(const BlockBandedMatrix::Block& l);

using BlockVector = Eigen::Matrix<double, BlockBandedMatrix::kSize, 1>;

/// L^-1 x, and L'^-1 x.
BlockVector Solved(const BlockBandedMatrix::Block& l, const BlockVector& x);
BlockVector SolvedTransposed(const BlockBandedMatrix::Block& l, const BlockVector& x);

}  // namespace tagtwist
