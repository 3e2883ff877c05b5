#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tagtwist::internal {

/// What a request says of where it comes from and what it wants.
struct WebRequest {
  std::string target;                 // "/?token=..."
  std::string host;                   // header Host; empty: none
  std::optional<std::string> origin;  // header Origin, which browsers send
  bool is_foxglove = false;           // asks for Foxglove's protocol
};

/// Who may see the page and the streams.
struct WebRules {
  std::string token;  // needed where there is one; without, the machine itself alone is served
  uint16_t port = 0;
  /// Why a request is refused, in a few words; nullopt: it is not. Without a token Host must name
  /// this machine's own address, so that no name that someone points at it (DNS rebinding) brings a
  /// page of theirs in; an Origin must be the page's own. With one, Foxglove's own pages may be
  /// anywhere.
  std::optional<std::string> Refusal(const WebRequest& request) const;
};

/// The path of a target, without its query.
std::string_view PathOf(std::string_view target);
/// The value of a key of its query as it stands there; empty where it has none.
std::string_view QueryValue(std::string_view target, std::string_view key);

/// 128 random bits as hexadecimal digits; empty where the system has none.
std::string RandomToken();

}  // namespace tagtwist::internal
