#include "estimator/report/files/map_sheets.h"

#include <utility>

#include "frontend/io/setup/tag_map_file.h"
#include "frontend/types/tag_planes.h"

namespace tagtwist::internal {
namespace {

SheetTag PlaceTag(const Tag& tag, TagPattern pattern, const Pose& sheet_from_world) {
  const Pose sheet_from_tag = sheet_from_world * tag.world_from_tag;
  SheetTag out;
  out.id = tag.id;
  out.cell_mm = kMmPerM * tag.size_m / pattern.square_cells;
  out.right = (sheet_from_tag.rotation() * Eigen::Vector3d::UnitX()).head<2>();
  out.up = (sheet_from_tag.rotation() * Eigen::Vector3d::UnitY()).head<2>();
  const double paper_mm = out.cell_mm * pattern.cells;
  out.left_top_mm =
      kMmPerM * sheet_from_tag.translation().head<2>() + 0.5 * paper_mm * (out.up - out.right);
  for (const double across : {0.0, paper_mm}) {
    for (const double down : {0.0, paper_mm}) {
      out.paper_mm.extend(out.left_top_mm + across * out.right - down * out.up);
    }
  }
  out.pattern = std::move(pattern);
  return out;
}

}  // namespace

Result<std::vector<MapSheet>> MapSheets(const TagMap& map) {
  if (const auto problem = CheckTagMap(map)) return Error{*problem};
  std::vector<int> ids;
  for (const Tag& tag : map.tags()) ids.push_back(tag.id);
  auto patterns = MakeTagPatterns(map.family(), ids);
  if (!patterns) return patterns.error();
  const TagPlanes planes = FindTagPlanes(map.tags());
  std::vector<MapSheet> out(planes.world_from_plane.size());
  for (size_t i = 0; i < out.size(); ++i) out[i].world_from_sheet = planes.world_from_plane[i];
  for (size_t i = 0; i < map.tags().size(); ++i) {
    const Tag& tag = map.tags()[i];
    MapSheet& sheet = out[planes.plane_of_tag.at(tag.id)];
    sheet.tags.push_back(PlaceTag(tag, std::move((*patterns)[i]), Inverse(sheet.world_from_sheet)));
    sheet.box_mm.extend(sheet.tags.back().paper_mm);
  }
  return out;
}

std::vector<CellRun> BlackRuns(const TagPattern& pattern) {
  std::vector<CellRun> out;
  for (int row = 0; row < pattern.cells; ++row) {
    for (int column = 0; column < pattern.cells; ++column) {
      if (pattern.IsWhite(column, row)) continue;
      int end = column;
      while (end < pattern.cells && !pattern.IsWhite(end, row)) ++end;
      out.push_back({column, row, end - column});
      column = end;
    }
  }
  return out;
}

}  // namespace tagtwist::internal
