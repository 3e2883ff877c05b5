// Ratios of units.
#pragma once

namespace tagtwist::internal {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegreesPerRadian = 57.29577951308232;

}  // namespace tagtwist::internal
