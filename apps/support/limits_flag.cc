#include "apps/support/limits_flag.h"

#include <gflags/gflags.h>

#include <cmath>
#include <sstream>
#include <type_traits>
#include <vector>

#include "frontend/base/nearest_name.h"
#include "frontend/base/number_text.h"

DEFINE_string(limits, "",
              "What the files that are read may ask for at most, as frame_pixels=4e8,file_bytes="
              "1e10, where the defaults refuse what you mean; SECURITY.md lists them.");

namespace tagtwist::internal {
namespace {

// Sets the limit of that name.
Status SetLimit(const std::string& name, double value, Limits* limits) {
  std::vector<std::string> names;
  bool known = false, whole = true;
  Limits::VisitFields(*limits, [&](const char* key, auto& limit) {
    using Number = std::decay_t<decltype(limit)>;
    names.emplace_back(key);
    if (name != key) return;
    known = true;
    whole = !std::is_integral_v<Number> || value == std::floor(value);
    // What is out of range is told by Problem(), which an integer could not hold.
    limit = static_cast<Number>(std::fmin(std::fmax(value, -1), 9e18));
  });
  if (!known) return Error{"no limit " + name + DidYouMean(name, names)};
  if (!whole) return Error{name + ": expected a whole number, got " + FormatNumber(value)};
  return Ok();
}

}  // namespace

Result<Limits> ParseLimits(const std::string& text) {
  Limits out;
  std::istringstream list(text);
  for (std::string item; std::getline(list, item, ',');) {
    const size_t equals = item.find('=');
    const auto value =
        equals == std::string::npos ? std::nullopt : ParseNumber(item.substr(equals + 1));
    if (!value) return Error{"--limits: expected KEY=NUMBER,..., got \"" + text + "\""};
    if (const Status set = SetLimit(item.substr(0, equals), *value, &out); !set) {
      return Error{"--limits: " + set.error().message};
    }
  }
  if (const auto problem = out.Problem()) return Error{"--limits: " + *problem};
  return out;
}

Result<Limits> LimitsFromFlag() { return ParseLimits(FLAGS_limits); }

}  // namespace tagtwist::internal
