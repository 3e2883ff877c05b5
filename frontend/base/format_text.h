#pragma once
#include <array>
#include <cstdio>
#include <string>

namespace tagtwist {

/// Text as printf makes it, cut at 399 characters.
template <typename... Args>
std::string Format(const char* format, Args... args) {
  std::array<char, 400> text;
  std::snprintf(text.data(), text.size(), format, args...);
  return text.data();
}

}  // namespace tagtwist
