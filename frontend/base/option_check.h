#pragma once
#include <cmath>
#include <optional>
#include <sstream>
#include <string>

namespace tagtwist::internal {

/// The rule that an option breaks, "key: expected in [0, 1], got 2", or nullopt. NaN breaks every
/// rule; an infinite `most` stands for no upper limit.
template <typename Number>
std::optional<std::string> CheckRange(const char* key, Number value, double least, double most) {
  const auto number = static_cast<double>(value);
  if (number >= least && number <= most && std::isfinite(number)) return std::nullopt;
  std::ostringstream problem;
  problem << key << ": expected ";
  if (std::isinf(most)) {
    problem << ">= " << least;
  } else {
    problem << "in [" << least << ", " << most << "]";
  }
  problem << ", got " << value;
  return problem.str();
}

/// As CheckRange, for options that must be greater than 0.
template <typename Number>
std::optional<std::string> CheckPositive(const char* key, Number value) {
  const auto number = static_cast<double>(value);
  if (number > 0 && std::isfinite(number)) return std::nullopt;
  std::ostringstream problem;
  problem << key << ": expected > 0, got " << value;
  return problem.str();
}

}  // namespace tagtwist::internal
