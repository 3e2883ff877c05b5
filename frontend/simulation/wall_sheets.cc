#include "frontend/simulation/wall_sheets.h"

#include <algorithm>
#include <cmath>

#include "frontend/simulation/scribble.h"
#include "frontend/types/tag_planes.h"

namespace tagtwist::internal {
namespace {

Patch Moved(const Pose& b_from_a, const Patch& patch) {
  Patch out = patch;
  out.centre = b_from_a * patch.centre;
  out.half_u = b_from_a.rotation() * patch.half_u;
  out.half_v = b_from_a.rotation() * patch.half_v;
  return out;
}

// Extent of a patch's corners along z [m].
double LowestM(const Patch& patch) {
  return patch.centre.z() - std::abs(patch.half_u.z()) - std::abs(patch.half_v.z());
}

bool IsOnFloor(const Patch& paper) {
  return std::abs(paper.centre.z()) < kNearFloorM && std::abs(LowestM(paper)) < kNearFloorM;
}

}  // namespace

std::vector<WallSheet> MakeWallSheets(const TagMap& map, const std::vector<Patch>& papers,
                                      const SceneOptions& options) {
  const TagPlanes planes = FindTagPlanes(map.tags());
  const std::vector<Eigen::AlignedBox2d> regions = TagRegions(planes, map.tags());
  std::vector<WallSheet> out;
  for (size_t k = 0; k < regions.size(); ++k) {
    const Pose plane_from_world = Inverse(planes.world_from_plane[k]);
    std::vector<Patch> papers_in_plane;
    double lowest_m = 0;
    bool is_floor = options.floor;
    for (size_t i = 0; i < papers.size(); ++i) {
      papers_in_plane.push_back(Moved(plane_from_world, papers[i]));
      if (planes.plane_of_tag.at(map.tags()[i].id) != k) continue;
      is_floor = is_floor && IsOnFloor(papers[i]);
      lowest_m = std::min(lowest_m, LowestM(papers_in_plane.back()));
    }
    if (is_floor) continue;
    const Pose world_from_sheet =
        planes.world_from_plane[k] * MakePose(Eigen::Quaterniond::Identity(), {0, 0, lowest_m});
    const Eigen::Vector2d centre = regions[k].center(), half = 0.5 * regions[k].sizes();
    Patch sheet;
    sheet.centre << centre, 0;
    sheet.half_u << half.x(), 0, 0;
    sheet.half_v << 0, half.y(), 0;
    sheet.grey = options.floor_grey;
    WallSheet wall{Moved(world_from_sheet, sheet), {}};
    for (const Patch& scribble :
         MakeScribbles(regions[k].min(), regions[k].max(), papers_in_plane, options, k + 1)) {
      wall.scribbles.push_back(Moved(world_from_sheet, scribble));
    }
    out.push_back(std::move(wall));
  }
  return out;
}

}  // namespace tagtwist::internal
