#pragma once
#include <string>
#include <vector>

#include "estimator/calibration/calibration.h"

namespace tagtwist::internal {

/// How far a tag was moved from where the map had it, without what all tags moved as one, and how
/// well that is known [m].
struct TagMove {
  int id = -1;
  double up_m = 0, up_sigma_m = 0;  // along the tag's normal in the map
  double within_m = 0;              // in its plane
  double position_sigma_m = 0;      // the greatest of the three coordinates'
  double turn_rad = 0;
};
/// Moves of the tags that were seen, in the order of the map; empty where no tag was refined.
std::vector<TagMove> TagMoves(const Calibration& calibration);

/// A tag's bend as refined, and how well it is known [m].
struct TagBend {
  int id = -1;
  double bend_m = 0, sigma_m = 0;
};
/// Bends of the tags that were seen, in the order of the map; empty where none was refined.
std::vector<TagBend> TagBends(const Calibration& calibration);

/// The map's scale (MapScaleDirection) and the focal length.
struct ScaleAndFocal {
  double scale = 0, scale_sigma = 0;  // relative
  double focal = 0, focal_sigma = 0;  // relative
  double correlation = 0;
};
ScaleAndFocal CompareScaleAndFocal(const Calibration& calibration);

/// The calibration in words, one line each: what changed and by how many sigmas, what was not
/// applied and why, what this motion does not show.
std::vector<std::string> CalibrationText(const Calibration& calibration);

}  // namespace tagtwist::internal
