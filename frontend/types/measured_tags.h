#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// What FindTags found in one frame.
struct TagsOfFrame {
  std::vector<TagDetection> tags;
  std::vector<int> doubled_ids = {};  // FrameMeasurements::doubled_ids
};

/// What FindTags found in the frames of a recording, by stamp; frames without a tag need no entry.
using MeasuredTags = std::map<int64_t, TagsOfFrame>;

}  // namespace tagtwist::internal
