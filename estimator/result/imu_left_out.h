#pragma once
#include <optional>
#include <string>
#include <vector>

namespace tagtwist::internal {

/// The warning of an estimate that was asked to take the IMU, and could not for that reason.
inline std::string ImuLeftOut(const std::string& reason) {
  return "the IMU is left out: " + reason;
}

/// That reason, where an estimate's warnings have one.
inline std::optional<std::string> WhyImuIsLeftOut(const std::vector<std::string>& warnings) {
  const std::string begin = ImuLeftOut("");
  for (const std::string& warning : warnings) {
    if (warning.compare(0, begin.size(), begin) == 0) return warning.substr(begin.size());
  }
  return std::nullopt;
}

}  // namespace tagtwist::internal
