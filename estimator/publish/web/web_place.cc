#include "estimator/publish/web/web_place.h"

#include <unistd.h>

#include <array>

#include "estimator/publish/web/web_rules.h"

namespace tagtwist::internal {
namespace {

// An address that stands for all of the machine's own is told by its name.
std::string NameInLink(const std::string& address) {
  if (address == "0.0.0.0" || address == "::") {
    std::array<char, 256> name{};
    if (::gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0') return name.data();
  }
  return address.find(':') == std::string::npos ? address : "[" + address + "]";
}

}  // namespace

Result<WebPlace> WebPlaceOf(const std::optional<std::string>& listen) {
  WebPlace out;
  if (!listen) return out;
  out.address = *listen;
  out.token = RandomToken();
  if (out.token.empty()) return Error{"--listen: the system has no random numbers"};
  return out;
}

std::string LinkTo(const WebPlace& place, uint16_t port) {
  return NameInLink(place.address) + ":" + std::to_string(port) + "/" +
         (place.token.empty() ? "" : "?token=" + place.token);
}

}  // namespace tagtwist::internal
