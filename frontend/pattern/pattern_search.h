#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "frontend/pattern/pattern_model.h"

namespace cv {
class Mat;
}

namespace tagtwist::internal {

/// A pixel of the image, and where it is without the lens's distortion.
struct PatternPlace {
  int x = 0, y = 0;
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
};

/// A shift, and how well the pattern correlates with the image there, -1 to 1.
struct PatternMatch {
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  double correlation = -1;
};

/// The shift in whole pixels, up to `reach` either way, at which a pattern with corners p1..p4 (as
/// places have it: undistorted) correlates best with an 8-bit gray image; from as many of the
/// places as tell.
PatternMatch SearchPattern(const cv::Mat& gray, const PatternModel& model,
                           const NormalTable& normal, const std::array<Eigen::Vector2d, 4>& corners,
                           const std::vector<PatternPlace>& places, int reach);

/// The places that tell of more than greys: those within reach_px of an edge of the pattern; and
/// every fourth of the others, for the greys.
std::vector<PatternPlace> ThinPlaces(const PatternModel& model,
                                     const std::array<Eigen::Vector2d, 4>& corners,
                                     const std::vector<PatternPlace>& places, double reach_px);

}  // namespace tagtwist::internal
