#include "frontend/base/set_limit.h"

#include <cmath>
#include <type_traits>
#include <vector>

#include "frontend/base/nearest_name.h"
#include "frontend/base/number_text.h"

namespace tagtwist::internal {

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

}  // namespace tagtwist::internal
