#include "estimator/report/files/map_svg.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "estimator/report/files/map_sheets.h"
#include "frontend/base/format_text.h"
#include "frontend/types/tag_planes.h"

namespace tagtwist::internal {
namespace {

constexpr double kMarginMm = 20, kBarMm = 100;

// The black cells as runs of each row; a cell is one unit, the tag's paper starts at (0, 0).
std::string BlackCells(const TagPattern& pattern) {
  std::string path;
  for (const CellRun& run : BlackRuns(pattern)) {
    path += Format("M%d %dh%dv1H%dz", run.column, run.row, run.length, run.column);
  }
  return path;
}

// A tag's group: cells to millimetres on the sheet, y down.
std::string DrawTag(const SheetTag& tag, const Eigen::Vector2d& left_top_mm) {
  const Eigen::Vector2d right = tag.cell_mm * tag.right, up = tag.cell_mm * tag.up;
  const Eigen::Vector2d corner = tag.left_top_mm;
  const int cells = tag.pattern.cells;
  return Format("<g transform=\"matrix(%.6g %.6g %.6g %.6g %.6f %.6f)\"><title>%d</title>",
                right.x(), -right.y(), -up.x(), up.y(), corner.x() - left_top_mm.x(),
                left_top_mm.y() - corner.y(), tag.id) +
         Format("<rect width=\"%d\" height=\"%d\" fill=\"#fff\"/><path d=\"", cells, cells) +
         BlackCells(tag.pattern) + "\"/></g>\n";
}

}  // namespace

Result<std::string> MapSvg(const TagMap& map) {
  const auto sheets = MapSheets(map);
  if (!sheets) return sheets.error();
  std::string body;
  double x = kMarginMm, height = 0;
  for (const MapSheet& sheet : *sheets) {
    const Eigen::Vector2d left_top(sheet.box_mm.min().x() - x, sheet.box_mm.max().y() + kMarginMm);
    for (const SheetTag& tag : sheet.tags) body += DrawTag(tag, left_top);
    x += std::max(sheet.box_mm.sizes().x(), kBarMm) + kMarginMm;
    height = std::max(height, sheet.box_mm.sizes().y());
  }
  height += 3 * kMarginMm;
  const double bar_y = height - kMarginMm;
  body += Format("<path d=\"M%g %gh%g\" stroke=\"#000\" stroke-width=\"0.5\"/>\n", kMarginMm, bar_y,
                 kBarMm) +
          Format("<text x=\"%g\" y=\"%g\" font-size=\"5\">100 mm; %s</text>\n", kMarginMm,
                 bar_y + 7, DescribeMap(map).c_str());
  return Format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.3fmm\" height=\"%.3fmm\" "
             "viewBox=\"0 0 %.3f %.3f\" shape-rendering=\"crispEdges\">\n",
             x, height, x, height) +
         "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n" + body + "</svg>\n";
}

std::string DescribeMap(const TagMap& map) {
  Eigen::AlignedBox3d box;
  int first = map.tags().front().id, last = first;
  double least_m = map.tags().front().size_m, most_m = least_m;
  for (const Tag& tag : map.tags()) {
    first = std::min(first, tag.id);
    last = std::max(last, tag.id);
    least_m = std::min(least_m, tag.size_m);
    most_m = std::max(most_m, tag.size_m);
    for (const Eigen::Vector3d& corner : map.CornersInWorld(tag.id)) box.extend(corner);
  }
  const size_t planes = FindTagPlanes(map.tags()).world_from_plane.size();
  const std::string size = least_m == most_m
                               ? Format("%g mm", kMmPerM * least_m)
                               : Format("%g to %g mm", kMmPerM * least_m, kMmPerM * most_m);
  return Format("%zu tags of %s, ids %d to %d, %s, on %zu plane%s, %.2f x %.2f x %.2f m",
                map.tags().size(), map.family().c_str(), first, last, size.c_str(), planes,
                planes == 1 ? "" : "s", box.sizes().x(), box.sizes().y(), box.sizes().z());
}

}  // namespace tagtwist::internal
