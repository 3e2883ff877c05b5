#pragma once
#include "estimator/linear/block.h"

namespace tagtwist::internal {

/// Products and triangular solves of blocks. Column by column, each in registers from its first
/// summand to its last: at this size Eigen's general kernels spend more time on packing and on
/// choosing than on sums. Machines with AVX2 and FMA take half the time; the last digits are then
/// others. Lower triangular L always has zeros above its diagonal.

/// c -= a b.
void SubtractProduct(const Block& a, const Block& b, Block* c);
/// c -= a b'.
void SubtractProductTransposed(const Block& a, const Block& b, Block* c);
/// c += sign a a' in the lower triangle, sign 1 or -1; above it c may take any value.
void AddSquare(double sign, const Block& a, Block* c);
/// L L' = a in a's place, of which only the lower triangle is read; false where it is not positive
/// definite.
bool FactorInPlace(Block* a);
/// x = x L'^-1.
void SolveRightTransposed(const Block& l, Block* x);
/// x = x L^-1.
void SolveRight(const Block& l, Block* x);
/// (L L')^-1.
Block InverseOf(const Block& l);

/// L^-1 x, and L'^-1 x.
BlockVector Solved(const Block& l, const BlockVector& x);
BlockVector SolvedTransposed(const Block& l, const BlockVector& x);

}  // namespace tagtwist::internal
