#pragma once
#include <algorithm>
#include <cctype>
#include <string>

namespace tagtwist::internal {

/// Whether files may be called after it: letters, digits, - and _, at most 64.
inline bool IsPlainName(const std::string& name) {
  constexpr size_t kMost = 64;
  return !name.empty() && name.size() <= kMost && std::all_of(name.begin(), name.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
  });
}

}  // namespace tagtwist::internal
