#include "estimator/publish/web/web_rules.h"

#include <sys/random.h>

#include <array>

#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

// Takes as long wherever they differ.
bool AreEqual(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return difference == 0;
}

bool IsOwnHost(std::string_view host, uint16_t port) {
  const std::string ending = ":" + std::to_string(port);
  const bool has_port =
      host.size() > ending.size() && host.substr(host.size() - ending.size()) == ending;
  if (has_port) host.remove_suffix(ending.size());
  if (!has_port && port != 80) return false;
  return host == "127.0.0.1" || host == "localhost" || host == "[::1]";
}

}  // namespace

std::string_view PathOf(std::string_view target) { return target.substr(0, target.find('?')); }

std::string_view QueryValue(std::string_view target, std::string_view key) {
  const size_t question = target.find('?');
  if (question == std::string_view::npos) return {};
  std::string_view rest = target.substr(question + 1);
  while (!rest.empty()) {
    const std::string_view part = rest.substr(0, rest.find('&'));
    if (part.size() > key.size() && part.substr(0, key.size()) == key && part[key.size()] == '=') {
      return part.substr(key.size() + 1);
    }
    rest.remove_prefix(part.size() == rest.size() ? rest.size() : part.size() + 1);
  }
  return {};
}

std::optional<std::string> WebRules::Refusal(const WebRequest& request) const {
  if (request.host.empty()) return "no Host";
  const bool has_token = !token.empty();
  if (has_token && !AreEqual(QueryValue(request.target, "token"), token)) {
    return "the link's token is needed";
  }
  if (!has_token && !IsOwnHost(request.host, port)) {
    return "Host is not this machine's own address";
  }
  if (!request.origin || *request.origin == "http://" + request.host) return std::nullopt;
  if (has_token && request.is_foxglove) return std::nullopt;
  return request.is_foxglove ? "another page's Origin: start with --listen and use its token"
                             : "another page's Origin";
}

std::string RandomToken() {
  std::array<unsigned char, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) return "";
  std::string out;
  for (const unsigned char byte : bytes) out += Format("%02x", byte);
  return out;
}

}  // namespace tagtwist::internal
