#include "frontend/base/statistics/quantile.h"

#include <algorithm>
#include <cmath>

namespace tagtwist::internal {

double Quantile(std::vector<double> values, double fraction) {
  const double rank = std::ceil(fraction * static_cast<double>(values.size()));
  const auto index = static_cast<std::ptrdiff_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<size_t>(index)];
}

}  // namespace tagtwist::internal
