#pragma once
#include <string>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// The defaults with what --limits says instead; an error is a wrong use of it.
Result<Limits> LimitsFromFlag();

/// From a text: "frame_pixels=4e8,file_bytes=1e10"; empty: the defaults.
/// "--limits: expected KEY=NUMBER,..., got \"x\"", "--limits: depth: expected in [1, 1000], got 0".
Result<Limits> ParseLimits(const std::string& text);

}  // namespace tagtwist::internal
