#pragma once
#include <vector>

namespace tagtwist::internal {

/// The value at rank ceil(fraction * n) of the sorted values; fraction in [0, 1], values not empty.
double Quantile(std::vector<double> values, double fraction);

}  // namespace tagtwist::internal
