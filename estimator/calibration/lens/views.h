#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// What views of the tags can tell of a lens.
struct ViewsJudged {
  static constexpr int kColumns = 8, kRows = 6;
  std::array<int, kColumns * kRows> corners{};  // by cell of the image, row by row
  std::vector<Eigen::Vector2d> pixels;          // of all those corners
  int distinct = 0;                             // views that differ from one another
  std::vector<int> view;   // of each frame: which of those it is like, -1 where it has no pose
  double tilt_rad = 0;     // the largest angle between two views' optical axes, in the world
  double covered() const;  // share of the cells with a corner
};
/// Adds a tag's corners to those of an image's cells.
void CountCorners(const TagDetection& tag, int width, int height, ViewsJudged* to);
/// Views differ by 5 degrees, or by a seventh of the distance to what they show.
ViewsJudged JudgeViews(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                       const Camera& camera);

/// What speaks against a calibration by such views, with what would mend it, one line each.
std::vector<std::string> MissingOf(const ViewsJudged& views);

/// Stamps, sorted, of up to 60 of the frames, of every view one, then of every view a second, and
/// so on; each with its successor where that came within 0.1 s, which tells how the camera moved.
std::vector<int64_t> SpreadOver(const ViewsJudged& views,
                                const std::vector<FrameMeasurements>& frames);

}  // namespace tagtwist::internal
