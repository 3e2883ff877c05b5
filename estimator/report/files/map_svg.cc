#include "estimator/report/files/map_svg.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "frontend/base/format_text.h"
#include "frontend/io/setup/tag_map_file.h"
#include "frontend/types/tag_family.h"
#include "frontend/types/tag_planes.h"

namespace tagtwist::internal {
namespace {

constexpr double kMmPerM = 1000, kMarginMm = 20, kBarMm = 100;

// The tags of one plane, in its frame [mm].
struct Sheet {
  Eigen::AlignedBox2d box;
  std::vector<size_t> tags;
};

// The black cells as runs of each row; a cell is one unit, the tag's paper starts at (0, 0).
std::string BlackCells(const TagPattern& pattern) {
  std::string path;
  for (int row = 0; row < pattern.cells; ++row) {
    for (int column = 0; column < pattern.cells; ++column) {
      if (pattern.IsWhite(column, row)) continue;
      int end = column;
      while (end < pattern.cells && !pattern.IsWhite(end, row)) ++end;
      path += Format("M%d %dh%dv1H%dz", column, row, end - column, column);
      column = end;
    }
  }
  return path;
}

// A tag's group: cells to millimetres on the sheet, y down.
std::string DrawTag(const Tag& tag, const TagPattern& pattern, const Pose& plane_from_tag,
                    const Eigen::Vector2d& left_top) {
  const double cell = kMmPerM * tag.size_m / pattern.square_cells;
  const Eigen::Vector3d right = cell * (plane_from_tag.rotation() * Eigen::Vector3d::UnitX());
  const Eigen::Vector3d up = cell * (plane_from_tag.rotation() * Eigen::Vector3d::UnitY());
  const Eigen::Vector3d corner =
      kMmPerM * plane_from_tag.translation() + 0.5 * pattern.cells * (up - right);
  return Format("<g transform=\"matrix(%.6g %.6g %.6g %.6g %.6f %.6f)\"><title>%d</title>",
                right.x(), -right.y(), -up.x(), up.y(), corner.x() - left_top.x(),
                left_top.y() - corner.y(), tag.id) +
         Format("<rect width=\"%d\" height=\"%d\" fill=\"#fff\"/><path d=\"", pattern.cells,
                pattern.cells) +
         BlackCells(pattern) + "\"/></g>\n";
}

std::vector<Sheet> MakeSheets(const TagMap& map, const TagPlanes& planes,
                              const std::vector<TagPattern>& patterns) {
  std::vector<Sheet> sheets(planes.world_from_plane.size());
  for (size_t i = 0; i < map.tags().size(); ++i) {
    Tag tag = map.tags()[i];
    const size_t plane = planes.plane_of_tag.at(tag.id);
    tag.world_from_tag = Inverse(planes.world_from_plane[plane]) * tag.world_from_tag;
    tag.size_m *= static_cast<double>(patterns[i].cells) / patterns[i].square_cells;
    for (const Eigen::Vector3d& corner : TagCornersInWorld(tag)) {
      sheets[plane].box.extend(Eigen::Vector2d(kMmPerM * corner.head<2>()));
    }
    sheets[plane].tags.push_back(i);
  }
  return sheets;
}

}  // namespace

Result<std::string> MapSvg(const TagMap& map) {
  if (const auto problem = CheckTagMap(map)) return Error{*problem};
  std::vector<int> ids;
  for (const Tag& tag : map.tags()) ids.push_back(tag.id);
  const auto patterns = MakeTagPatterns(map.family(), ids);
  if (!patterns) return patterns.error();
  const TagPlanes planes = FindTagPlanes(map.tags());
  std::string body;
  double x = kMarginMm, height = 0;
  const std::vector<Sheet> sheets = MakeSheets(map, planes, *patterns);
  for (size_t s = 0; s < sheets.size(); ++s) {
    const Sheet& sheet = sheets[s];
    const Eigen::Vector2d left_top(sheet.box.min().x() - x, sheet.box.max().y() + kMarginMm);
    const Pose plane_from_world = Inverse(planes.world_from_plane[s]);
    for (const size_t i : sheet.tags) {
      const Tag& tag = map.tags()[i];
      body += DrawTag(tag, (*patterns)[i], plane_from_world * tag.world_from_tag, left_top);
    }
    x += std::max(sheet.box.sizes().x(), kBarMm) + kMarginMm;
    height = std::max(height, sheet.box.sizes().y());
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
