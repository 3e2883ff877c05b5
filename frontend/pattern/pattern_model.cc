#include "frontend/pattern/pattern_model.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tagtwist::internal {
namespace {

constexpr int kMostEdges = 12;
constexpr double kWidestBlur = 1.4;  // [cells], standard deviation: 2 * 3.25 * 1.4 < kMostEdges

// What a pixel sees along one axis: the shares of the cells `first` .. `first + edges`, and the
// density and its derivative at the edges between them. What lies beyond is not set: one is made
// for each pixel.
struct AxisView {
  int first = 0, edges = 0;
  std::array<double, kMostEdges + 1> share;
  std::array<double, kMostEdges> density, slope;
};

AxisView ViewAxis(double position, double variance, int cells, const NormalTable& normal) {
  AxisView out;
  const double sigma = std::clamp(std::sqrt(std::max(variance, 1e-6)), 1e-3, kWidestBlur);
  const double reach = NormalTable::kReach * sigma, inverse = 1 / sigma;
  const double clamped = std::clamp(position, -1e3, 1e3);
  const int first_edge = std::max(static_cast<int>(std::ceil(clamped - reach)), 1);
  const int last_edge = std::min(static_cast<int>(std::floor(clamped + reach)), cells - 1);
  if (last_edge < first_edge) {
    out.first = std::clamp(static_cast<int>(std::floor(clamped)), 0, cells - 1);
    out.share[0] = 1;
    return out;
  }
  out.first = first_edge - 1;
  double beyond = 1;  // share of all cells from here on
  for (int edge = first_edge; edge <= last_edge && out.edges < kMostEdges; ++edge) {
    const double x = (position - edge) * inverse;
    const NormalTable::Value value = normal.At(x);
    const auto i = static_cast<size_t>(out.edges++);
    out.share[i] = beyond - value.cdf;
    out.density[i] = value.density * inverse;
    out.slope[i] = -x * out.density[i] * inverse;
    beyond = value.cdf;
  }
  out.share[static_cast<size_t>(out.edges)] = beyond;
  return out;
}

}  // namespace

PatternModel::PatternModel(const TagPattern& pattern)
    : cells_(pattern.cells),
      square_half_(0.5 * pattern.square_cells),
      white_(pattern.white.begin(), pattern.white.end()) {
  const auto at = [&](int column, int row) {
    return pattern.IsWhite(std::clamp(column, 0, cells_ - 1), std::clamp(row, 0, cells_ - 1))
               ? 1.0F
               : 0.0F;
  };
  for (int y = 0; y < cells_; ++y) {
    for (int x = 0; x < cells_; ++x) {
      const float own = at(x, y), left = at(x - 1, y) - own, right = at(x + 1, y) - own;
      std::array<float, 9> c = {own, left, right};
      for (const size_t side : {size_t{3}, size_t{6}}) {
        const int beyond = side == 3 ? y - 1 : y + 1;
        c[side] = at(x, beyond) - own;
        c[side + 1] = at(x - 1, beyond) - at(x, beyond) - left;
        c[side + 2] = at(x + 1, beyond) - at(x, beyond) - right;
      }
      around_.push_back(c);
    }
  }
}

PatternSample<double> PatternModel::At(double u, double v, const CellBlur& blur,
                                       const NormalTable& normal) const {
  const AxisView across = ViewAxis(u + 0.5 * cells_, blur.uu, cells_, normal);
  const AxisView down = ViewAxis(v + 0.5 * cells_, blur.vv, cells_, normal);
  PatternSample<double> out{};
  double uuv = 0, uvv = 0, uuvv = 0, last_value = 0, last_u = 0, last_uu = 0;
  for (int j = 0; j <= down.edges; ++j) {
    const double* row = &white_[static_cast<size_t>((down.first + j) * cells_ + across.first)];
    double value = row[0] * across.share[0], du = 0, duu = 0;
    for (int i = 0; i < across.edges; ++i) {
      const auto k = static_cast<size_t>(i);
      const double step = row[i + 1] - row[i];
      value += row[i + 1] * across.share[k + 1];
      du += step * across.density[k];
      duu += step * across.slope[k];
    }
    const double share = down.share[static_cast<size_t>(j)];
    out.value += share * value;
    out.u += share * du;
    out.uu += share * duu;
    if (j > 0) {
      const double density = down.density[static_cast<size_t>(j - 1)];
      const double slope = down.slope[static_cast<size_t>(j - 1)];
      out.v += density * (value - last_value);
      out.vv += slope * (value - last_value);
      out.uv += density * (du - last_u);
      uvv += slope * (du - last_u);
      uuv += density * (duu - last_uu);
      uuvv += slope * (duu - last_uu);
    }
    last_value = value;
    last_u = du;
    last_uu = duu;
  }
  out.value += blur.uv * (out.uv + 0.5 * blur.uv * uuvv);
  out.u += blur.uv * uuv;
  out.v += blur.uv * uvv;
  out.uv += blur.uv * uuvv;
  return out;
}

}  // namespace tagtwist::internal
