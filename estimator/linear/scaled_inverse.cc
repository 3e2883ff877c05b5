#include "estimator/linear/scaled_inverse.h"

#include <algorithm>
#include <cmath>

namespace tagtwist::internal {
namespace {

// Calls f(i, j) for the blocks within the band of the columns [from, to).
template <typename F>
void ForBlocks(const BlockBandedMatrix& m, int from, int to, const F& f) {
  for (int j = from; j < to; ++j) {
    for (int i = j; i <= std::min(m.size() - 1, j + m.bandwidth()); ++i) f(i, j);
  }
}

// The blocks of a matrix of the states from `at` on, as many as the state before may reach.
BlockBandedMatrix Corner(const BlockBandedMatrix& m, int at) {
  const int n = std::min(m.bandwidth(), m.size() - at);
  BlockBandedMatrix out(n, std::max(0, n - 1));
  ForBlocks(out, 0, n, [&](int i, int j) { out.At(i, j) = m.At(at + i, at + j); });
  return out;
}

void PutCorner(const BlockBandedMatrix& corner, int at, BlockBandedMatrix* m) {
  ForBlocks(corner, 0, corner.size(),
            [&](int i, int j) { m->At(at + i, at + j) = corner.At(i, j); });
}

// tr(a b) of two symmetric matrices, over the blocks within b's band in those columns.
double TraceOfProduct(const BlockBandedMatrix& a, const BlockBandedMatrix& b, int from, int to) {
  double sum = 0;
  ForBlocks(b, from, to, [&](int i, int j) {
    sum += (i == j ? 1 : 2) * a.At(i, j).cwiseProduct(b.At(i, j)).sum();
  });
  return sum;
}

}  // namespace

void ScaledInverse::Factorise(const BlockBandedMatrix& total, const BlockBandedMatrix& part,
                              PieceColumns own, size_t number, BlockBandedMatrix* matrix) {
  *matrix = total;
  if (log_scale_ != 0) {
    const double more = std::exp(log_scale_) - 1;
    ForBlocks(part, 0, part.size(),
              [&](int i, int j) { matrix->At(i, j) += more * part.At(i, j); });
  }
  if (number > 0) PutCorner(left_[number - 1], own.begin, matrix);
  if (FactorColumns(own.begin, own.end, matrix) >= 0) is_ok_ = false;
  if (number == left_.size()) left_.push_back(Corner(*matrix, own.end));
}

void ScaledInverse::InvertBack(const BlockBandedMatrix& part, PieceColumns own,
                               BlockBandedMatrix* matrix) {
  PutCorner(inverse_after_, own.end, matrix);
  InvertColumns(own.begin, own.end, matrix);
  inverse_after_ = Corner(*matrix, own.begin);
  trace_ += TraceOfProduct(*matrix, part, own.begin, own.end);
}

}  // namespace tagtwist::internal
