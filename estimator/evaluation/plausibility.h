#pragma once
#include <vector>

#include "frontend/base/fault.h"
#include "frontend/types/body_state.h"
#include "frontend/types/camera.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// What of a set-up cannot be: tags larger than a house or smaller than a letter (millimetres taken
/// for metres), fields of view that no lens has, a principal point off the image.
std::vector<Fault> ImplausibleSetUp(const Camera& camera, const TagMap& map);
/// What of that is the map's alone: sizes, and tags of one sheet without a white border between
/// them (spacings in metres taken for shares of a size).
std::vector<Fault> ImplausibleMap(const TagMap& map);

/// A pose of the body and its moment.
struct TimedPose {
  int64_t t_ns = 0;
  Pose world_from_body;
};

/// What of a motion cannot be: a body faster than anything that a camera on it sees tags from, or
/// frames seconds apart between which it moves on as smoothly as in a film. Both come of stamps in
/// another unit. Poses in order of time.
std::vector<Fault> ImplausibleMotion(const std::vector<TimedPose>& poses);

}  // namespace tagtwist::internal
