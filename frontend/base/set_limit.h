#pragma once
#include <string>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Sets the limit of that name; whether the value is in range Limits::Problem() tells.
/// "no limit frame_pixel: did you mean frame_pixels?", "nodes: expected a whole number, got 1.5".
Status SetLimit(const std::string& name, double value, Limits* limits);

}  // namespace tagtwist::internal
