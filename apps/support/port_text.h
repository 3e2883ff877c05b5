#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "frontend/base/number_text.h"

namespace tagtwist::internal {

/// The port of --page where none is said.
inline constexpr uint16_t kUsualPort = 8765;

/// A port's number, from `least` on.
inline std::optional<uint16_t> PortOf(const std::string& text, int64_t least) {
  const auto port = ParseInteger(text);
  if (!port || *port < least || *port > 65535) return std::nullopt;
  return static_cast<uint16_t>(*port);
}

}  // namespace tagtwist::internal
