#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/types/tag_family.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

constexpr double kMmPerM = 1000;

/// A tag on the plane of its sheet, as printed.
struct SheetTag {
  int id = 0;
  TagPattern pattern;
  double cell_mm = 0;
  Eigen::Vector2d right, up;     // of the tag as printed, unit, in the sheet's frame
  Eigen::Vector2d left_top_mm;   // of its paper, one white cell around the tag
  Eigen::AlignedBox2d paper_mm;  // what its paper covers
};

/// The tags of one plane in its frame [mm]: x to the right, y up, z out of the paper.
struct MapSheet {
  Pose world_from_sheet;  // [m]
  Eigen::AlignedBox2d box_mm;
  std::vector<SheetTag> tags;
};

/// A map's sheets, one a plane of tags. Errors: as CheckTagMap.
Result<std::vector<MapSheet>> MapSheets(const TagMap& map);

/// A tag's black cells as runs in rows: column, row, length, counted from its paper's left top.
struct CellRun {
  int column = 0, row = 0, length = 0;
};
std::vector<CellRun> BlackRuns(const TagPattern& pattern);

}  // namespace tagtwist::internal
