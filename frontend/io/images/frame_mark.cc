#include "frontend/io/images/frame_mark.h"

#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

constexpr std::string_view kKey = "t_ns=";

}  // namespace

std::string FrameMark(int64_t t_ns) { return std::string(kKey) + std::to_string(t_ns); }

std::optional<int64_t> ReadFrameMark(std::string_view text) {
  if (text.substr(0, kKey.size()) != kKey) return std::nullopt;
  const auto t_ns = ParseInteger(text.substr(kKey.size()));
  if (!t_ns || *t_ns > kMostStampNs || *t_ns < -kMostStampNs) return std::nullopt;
  return t_ns;
}

}  // namespace tagtwist::internal
