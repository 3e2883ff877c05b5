#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// The factor by which all tags of a map would have to be scaled about their centres to fit a
/// frame.
struct SizeFactor {
  double factor = 1;
  double squared_error_px2 = 0;      // sum over all corners, with the factor
  double squared_error_as_told = 0;  // the same with the map as it is [px^2]
};

/// Of the tags of one frame: the places of tags to one another against their own sizes. nullopt
/// with fewer than two tags of the map, or where no factor makes them agree on a pose.
std::optional<SizeFactor> FitSizeFactor(const std::vector<TagDetection>& tags, const TagMap& map,
                                        const Camera& camera);

/// The factor that at least 70 % of the frames agree on (nullopt: a frame without one), to 5 % of
/// it, where it differs from 1 by more than 6 % and takes away three quarters of the squared
/// errors; nullopt where there is none.
std::optional<double> CommonSizeFactor(const std::vector<std::optional<SizeFactor>>& frames);

/// What is wrong, and what to do about it, in one line, with the factor; and whether it is that of
/// a size measured with the white border of the map's family.
std::string SizeFactorText(double factor, const TagMap& map);

}  // namespace tagtwist::internal
