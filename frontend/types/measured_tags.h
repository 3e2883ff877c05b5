#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// What FindTags found in the frames of a recording, by stamp; frames without a tag need no entry.
using MeasuredTags = std::map<int64_t, std::vector<TagDetection>>;

}  // namespace tagtwist::internal
