#include "estimator/linear/block_kernels.h"

#include <cmath>

#include "estimator/linear/lanes.h"

namespace tagtwist::internal {
namespace {

// The last rows of a column, an even number of them, in registers.
template <int kLanes, int kRows>
struct Rows {
  static constexpr int kOfPart = kRows < kLanes ? 2 : kLanes, kFirst = kBlockSize - kRows;
  using Part = typename Lanes<kOfPart>::InMemory;

  TAGTWIST_INLINE void Load(const double* column) {
    first = reinterpret_cast<const Part*>(column + kFirst)->lanes;
    rest.Load(column);
  }
  TAGTWIST_INLINE void Store(double* column) const {
    reinterpret_cast<Part*>(column + kFirst)->lanes = first;
    rest.Store(column);
  }
  // Adds by times a column.
  TAGTWIST_INLINE void Add(double by, const double* column) {
    first += by * reinterpret_cast<const Part*>(column + kFirst)->lanes;
    rest.Add(by, column);
  }
  TAGTWIST_INLINE void Scale(double by) {
    first *= by;
    rest.Scale(by);
  }

  typename Lanes<kOfPart>::Vector first;
  Rows<kLanes, kRows - kOfPart> rest;
};

template <int kLanes>
struct Rows<kLanes, 0> {
  TAGTWIST_INLINE void Load(const double* /*column*/) {}
  TAGTWIST_INLINE void Store(double* /*column*/) const {}
  TAGTWIST_INLINE void Add(double /*by*/, const double* /*column*/) {}
  TAGTWIST_INLINE void Scale(double /*by*/) {}
};

TAGTWIST_INLINE double* At(Block* a, int column) { return a->data() + kBlockSize * column; }
TAGTWIST_INLINE const double* At(const Block& a, int column) {
  return a.data() + kBlockSize * column;
}

// Columns of the factor from the first of those rows on, four at most: what lies above is zero, or
// is to be.
template <int kLanes, int kRows>
TAGTWIST_INLINE bool FactorColumns(Block* a) {
  constexpr int kFirst = kBlockSize - kRows, kLast = kRows > 4 ? kFirst + 4 : kBlockSize;
  for (int j = kFirst; j < kLast; ++j) {
    Rows<kLanes, kRows> column;
    column.Load(At(a, j));
    for (int k = 0; k < j; ++k) column.Add(-At(a, k)[j], At(a, k));
    column.Store(At(a, j));
    const double pivot = At(a, j)[j];
    if (!(pivot > 0)) return false;
    column.Scale(1 / std::sqrt(pivot));
    column.Store(At(a, j));
    for (int i = 0; i < j; ++i) At(a, j)[i] = 0;
  }
  return true;
}

template <int kLanes>
TAGTWIST_INLINE bool Factorise(Block* a) {
  return FactorColumns<kLanes, 18>(a) && FactorColumns<kLanes, 14>(a) &&
         FactorColumns<kLanes, 10>(a) && FactorColumns<kLanes, 6>(a) && FactorColumns<kLanes, 2>(a);
}

// c += sign a a' in those columns, from those rows on.
template <int kLanes, int kRows>
TAGTWIST_INLINE void AddSquareColumns(double sign, const Block& a, Block* c) {
  constexpr int kFirst = kBlockSize - kRows, kLast = kRows > 4 ? kFirst + 4 : kBlockSize;
  for (int j = kFirst; j < kLast; ++j) {
    Rows<kLanes, kRows> sum;
    sum.Load(At(c, j));
    for (int k = 0; k < kBlockSize; ++k) sum.Add(sign * At(a, k)[j], At(a, k));
    sum.Store(At(c, j));
  }
}

template <int kLanes>
TAGTWIST_INLINE void AddSquare(double sign, const Block& a, Block* c) {
  AddSquareColumns<kLanes, 18>(sign, a, c);
  AddSquareColumns<kLanes, 14>(sign, a, c);
  AddSquareColumns<kLanes, 10>(sign, a, c);
  AddSquareColumns<kLanes, 6>(sign, a, c);
  AddSquareColumns<kLanes, 2>(sign, a, c);
}

// c -= a b, where row k of b's column j is at kRowStep k + kColumnStep j.
template <int kLanes, int kRowStep, int kColumnStep>
TAGTWIST_INLINE void Subtract(const Block& a, const Block& b, Block* c) {
  for (int j = 0; j < kBlockSize; ++j) {
    Rows<kLanes, kBlockSize> sum;
    sum.Load(At(c, j));
    const double* const by = b.data() + kColumnStep * j;
    for (int k = 0; k < kBlockSize; ++k) sum.Add(-by[kRowStep * k], At(a, k));
    sum.Store(At(c, j));
  }
}

// Column j of x, less columns [first, last) times what `by` has at their steps, over the pivot.
template <int kLanes>
TAGTWIST_INLINE void SolveColumn(int j, int first, int last, const double* by, int step,
                                 double pivot, Block* x) {
  Rows<kLanes, kBlockSize> column;
  column.Load(At(x, j));
  for (int k = first; k < last; ++k) column.Add(-by[step * k], At(x, k));
  column.Scale(1 / pivot);
  column.Store(At(x, j));
}

template <int kLanes>
TAGTWIST_INLINE void DivideByTransposed(const Block& l, Block* x) {
  for (int j = 0; j < kBlockSize; ++j) {
    SolveColumn<kLanes>(j, 0, j, l.data() + j, kBlockSize, At(l, j)[j], x);
  }
}

template <int kLanes>
TAGTWIST_INLINE void Divide(const Block& l, Block* x) {
  for (int j = kBlockSize - 1; j >= 0; --j) {
    SolveColumn<kLanes>(j, j + 1, kBlockSize, At(l, j), 1, At(l, j)[j], x);
  }
}

TAGTWIST_WIDE bool FactoriseWide(Block* a) { return Factorise<4>(a); }
TAGTWIST_WIDE void AddSquareWide(double sign, const Block& a, Block* c) {
  AddSquare<4>(sign, a, c);
}
TAGTWIST_WIDE void SubtractWide(const Block& a, const Block& b, Block* c) {
  Subtract<4, 1, kBlockSize>(a, b, c);
}
TAGTWIST_WIDE void SubtractTransposedWide(const Block& a, const Block& b, Block* c) {
  Subtract<4, kBlockSize, 1>(a, b, c);
}
TAGTWIST_WIDE void DivideByTransposedWide(const Block& l, Block* x) { DivideByTransposed<4>(l, x); }
TAGTWIST_WIDE void DivideWide(const Block& l, Block* x) { Divide<4>(l, x); }

}  // namespace

void SubtractProduct(const Block& a, const Block& b, Block* c) {
  if (kIsWide) return SubtractWide(a, b, c);
  Subtract<2, 1, kBlockSize>(a, b, c);
}

void SubtractProductTransposed(const Block& a, const Block& b, Block* c) {
  if (kIsWide) return SubtractTransposedWide(a, b, c);
  Subtract<2, kBlockSize, 1>(a, b, c);
}

void AddSquare(double sign, const Block& a, Block* c) {
  if (kIsWide) return AddSquareWide(sign, a, c);
  AddSquare<2>(sign, a, c);
}

bool FactorInPlace(Block* a) { return kIsWide ? FactoriseWide(a) : Factorise<2>(a); }

void SolveRightTransposed(const Block& l, Block* x) {
  if (kIsWide) return DivideByTransposedWide(l, x);
  DivideByTransposed<2>(l, x);
}

void SolveRight(const Block& l, Block* x) {
  if (kIsWide) return DivideWide(l, x);
  Divide<2>(l, x);
}

Block InverseOf(const Block& l) {
  Block root = Block::Identity();  // L'^-1, upper triangular
  SolveRightTransposed(l, &root);
  Block out = Block::Zero();
  AddSquare(1, root, &out);
  out.triangularView<Eigen::StrictlyUpper>() = out.transpose();
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
