#pragma once
#include <cstddef>
#include <vector>

namespace tagtwist::internal {

/// The standard normal distribution cut off at +-kReach (0.1 % of it lies beyond) and scaled to a
/// total of 1, by table, for loops over pixels: errors below 1e-8.
class NormalTable {
 public:
  NormalTable();

  struct Value {
    double cdf = 0;      // from -infinity to x
    double density = 0;  // at x
  };
  Value At(double x) const {
    if (!(x > -kReach)) return {0, 0};
    if (!(x < kReach)) return {1, 0};
    const auto index = static_cast<size_t>((x + kReach) * kPerUnit + 0.5);
    const Value& near = values_[index];
    const double a = static_cast<double>(index) / kPerUnit - kReach, e = x - a;
    const double e2 = e * e, curve = a * a - 1;
    return {near.cdf + near.density * e * (1 - 0.5 * a * e + e2 * curve / 6),
            near.density * (1 - a * e + 0.5 * e2 * curve - a * e * e2 * (a * a - 3) / 6)};
  }

  static constexpr double kReach = 3.25;

 private:
  static constexpr int kPerUnit = 32;
  std::vector<Value> values_;
};

}  // namespace tagtwist::internal
