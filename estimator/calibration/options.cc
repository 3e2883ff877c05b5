#include "estimator/calibration/options.h"

#include <limits>
#include <type_traits>

#include "frontend/base/option_check.h"

namespace tagtwist {

using namespace internal;

std::optional<std::string> CalibrationOptions::Problem() const {
  std::optional<std::string> problem;
  VisitFields(*this, [&problem](const char* key, auto value) {
    const double least = std::is_integral_v<decltype(value)> ? 4 : 0;
    if (!problem) problem = CheckRange(key, value, least, std::numeric_limits<double>::infinity());
  });
  return problem;
}

}  // namespace tagtwist
