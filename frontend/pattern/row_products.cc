#include "frontend/pattern/row_products.h"

namespace tagtwist::internal {

RowProducts::RowProducts() {
  for (auto& row : products_) row.fill(Quad::Zero());
  gradient_.fill(Quad::Zero());
}

void RowProducts::Add(const Rows& rows, const Column& weights, const Column& residuals) {
  for (int k = 0; k < kPatternUnknowns; ++k) {
    weighted_.col(k).array() = rows.col(k).array() * weights;
  }
  for (int i = 0; i < kPatternUnknowns; i += 2) {
    for (int k = 0; k <= i; k += 4) AddBlock(rows, i, k);
  }
  for (int i = 0; i < kPatternUnknowns; ++i) {
    Quad& sum = gradient_[static_cast<size_t>(i)];
    for (int p = 0; p < kChunk; p += 4) {
      sum += weighted_.col(i).segment<4>(p).array() * residuals.segment<4>(p);
    }
  }
}

// 2 x 4 entries: so many sums stay in registers.
void RowProducts::AddBlock(const Rows& rows, int i, int k) {
  std::array<Quad, 8> sums;
  sums.fill(Quad::Zero());
  for (int p = 0; p < kChunk; p += 4) {
    const Quad a = weighted_.col(i).segment<4>(p), b = weighted_.col(i + 1).segment<4>(p);
    for (int m = 0; m < 4; ++m) {
      const Quad row = rows.col(k + m).segment<4>(p);
      sums[static_cast<size_t>(m)] += a * row;
      sums[static_cast<size_t>(m + 4)] += b * row;
    }
  }
  for (size_t m = 0; m < 4; ++m) {
    products_[static_cast<size_t>(i)][static_cast<size_t>(k) + m] += sums[m];
    products_[static_cast<size_t>(i) + 1][static_cast<size_t>(k) + m] += sums[m + 4];
  }
}

void RowProducts::Finish(Eigen::Matrix<double, kPatternUnknowns, kPatternUnknowns>* normal,
                         PatternVector* gradient) const {
  for (int i = 0; i < kPatternUnknowns; ++i) {
    const auto& row = products_[static_cast<size_t>(i)];
    for (int k = 0; k <= i; ++k) {
      (*normal)(i, k) = (*normal)(k, i) = static_cast<double>(row[static_cast<size_t>(k)].sum());
    }
    (*gradient)[i] = static_cast<double>(gradient_[static_cast<size_t>(i)].sum());
  }
}

}  // namespace tagtwist::internal
