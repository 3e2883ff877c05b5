#pragma once
#include <array>
#include <cstdarg>
#include <cstdio>
#include <string>

namespace tagtwist::internal {

/// Text as printf makes it, cut at 399 characters. The compiler checks the arguments against the
/// format.
[[gnu::format(printf, 1, 2)]] inline std::string Format(const char* format, ...) {
  std::array<char, 400> text;
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  return text.data();
}

}  // namespace tagtwist::internal
