#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/calibration/set_up/set_up_fit.h"
#include "frontend/base/fault.h"
#include "frontend/types/camera.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// The one mistake that explains the corners: ids that run along the other side of a grid, a focal
/// length, a resolution, a shifted or cropped image, a stretched one, a missing distortion, sizes
/// against spacings, gaps, a rolling shutter; or that no single one does and the map is another.
/// (That corners stand in another order, or in a mirror, SetUpCheck tells in the first frames.)
/// nullopt: the corners fit the set-up as given, or nothing speaks clearly. A fault must halve, or
/// nearly, the median error of the tags, and be as large as a person's mistake is, not a
/// calibration's tolerance: a set-up that is right within a few per cent is never accused. Frames
/// are in order of time; those with few tags count little, and a sample of them is used.
std::optional<Fault> FindSetUpFault(const std::vector<SeenTags>& frames, const Camera& camera,
                                    double line_time_s, const TagMap& map);

}  // namespace tagtwist::internal
