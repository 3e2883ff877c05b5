#include "frontend/pattern/normal_table.h"

#include <cmath>

namespace tagtwist::internal {

NormalTable::NormalTable() {
  const int last = static_cast<int>(2 * kReach * kPerUnit);
  const double beyond = 0.5 * std::erfc(kReach * std::sqrt(0.5)), scale = 1 / (1 - 2 * beyond);
  for (int i = 0; i <= last; ++i) {
    const double x = static_cast<double>(i) / kPerUnit - kReach;
    values_.push_back({scale * (0.5 * std::erfc(-x * std::sqrt(0.5)) - beyond),
                       scale * std::exp(-0.5 * x * x) * std::sqrt(0.5 / std::acos(-1.0))});
  }
}

}  // namespace tagtwist::internal
