#pragma once
#include <string_view>

namespace tagtwist::internal {

inline constexpr const char* kBlanks = " \t\r";

/// The text without the blanks at both its ends.
inline std::string_view Trim(std::string_view text) {
  const size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace tagtwist::internal
