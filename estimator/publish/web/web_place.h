#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Where a server listens, and what lets others in.
struct WebPlace {
  std::string address = "127.0.0.1";  // an IP address
  std::string token;                  // empty: none is needed
};

/// This machine alone, or, where `listen` is given, that address with a token drawn anew.
Result<WebPlace> WebPlaceOf(const std::optional<std::string>& listen);

/// What follows "http://" in the link to a page there: "127.0.0.1:8765/".
std::string LinkTo(const WebPlace& place, uint16_t port);

}  // namespace tagtwist::internal
