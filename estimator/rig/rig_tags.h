#pragma once
#include <algorithm>
#include <iterator>
#include <vector>

#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Of a frame's tags those that one camera of the rig sees.
inline std::vector<TagDetection> TagsOfCamera(const std::vector<TagDetection>& tags, int camera) {
  std::vector<TagDetection> out;
  std::copy_if(tags.begin(), tags.end(), std::back_inserter(out),
               [camera](const TagDetection& tag) { return tag.camera == camera; });
  return out;
}

}  // namespace tagtwist::internal
