#include "frontend/base/limits.h"

#include <type_traits>

#include "frontend/base/option_check.h"

namespace tagtwist {

using namespace internal;
namespace {

// Of these alone the readers could not keep their promises beyond: each level of depth takes
// some of the stack, and elements and tags are counted by an int.
double MostOf(const std::string& name) {
  if (name == "depth") return 1000;
  if (name == "tags") return 1e8;
  if (name == "elements") return 2147483647;
  if (name == "frame_pixels") return 1 << 30;  // OpenCV's own
  return 1e15;
}

}  // namespace

std::optional<std::string> Limits::Problem() const {
  std::optional<std::string> out;
  VisitFields(*this, [&](const char* name, const auto& value) {
    const double least = std::is_integral_v<std::decay_t<decltype(value)>> ? 1 : 1e-3;
    if (!out) out = CheckRange(name, value, least, MostOf(name));
  });
  return out;
}

namespace internal {

std::string RaisesLimit(const char* name) {
  return std::string(" (--limits ") + name + "=N raises that)";
}

bool MayInflate(uint64_t packed_bytes, uint64_t bytes, const Limits& limits) {
  return bytes <= static_cast<uint64_t>(limits.inflated_bytes) ||
         static_cast<double>(bytes) <= limits.inflated_ratio * static_cast<double>(packed_bytes);
}

}  // namespace internal
}  // namespace tagtwist
