#include "frontend/simulation/scene.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "frontend/base/option_check.h"
#include "frontend/base/statistics/random_stream.h"
#include "frontend/base/units.h"
#include "frontend/simulation/board_squares.h"
#include "frontend/simulation/scribble.h"
#include "frontend/simulation/wall_sheets.h"
#include "frontend/types/tag_planes.h"

namespace tagtwist::internal {
namespace {

constexpr uint64_t kOccluderPurpose = 2;  // of the random stream
constexpr double kScribbleMarginM = 1.0;  // floor around the map that carries scribble
constexpr double kMostScribbles = 1e6;

Patch MakeTagPatch(const Tag& tag, const TagPattern& pattern) {
  const double half = 0.5 * tag.size_m * pattern.cells / pattern.square_cells;
  Patch out;
  out.centre = tag.world_from_tag.translation();
  out.half_u = tag.world_from_tag.rotation() * Eigen::Vector3d(half, 0, 0);
  out.half_v = tag.world_from_tag.rotation() * Eigen::Vector3d(0, half, 0);
  out.pattern = &pattern;
  return out;
}

double AreaOfPlanes(const TagMap& map) {
  double sum_m2 = 0;
  for (const auto& region : TagRegions(FindTagPlanes(map.tags()), map.tags())) {
    sum_m2 += region.volume();
  }
  return sum_m2;
}

}  // namespace

Result<Scene> Scene::Make(const TagMap& map, const SceneOptions& options) {
  if (const auto problem = options.Problem()) return Error{*problem};
  if (const auto problem = map.Problem()) return Error{*problem};
  std::vector<int> ids;
  for (const Tag& tag : map.tags()) ids.push_back(tag.id);
  auto patterns = MakeTagPatterns(map.family(), ids);
  if (!patterns) return patterns.error();

  Scene out;
  out.options_ = options;
  out.patterns_ = std::make_shared<const std::vector<TagPattern>>(std::move(*patterns));
  out.all_tags_on_floor_ = true;
  Eigen::AlignedBox3d box;
  for (size_t i = 0; i < ids.size(); ++i) {
    out.tags_.push_back(MakeTagPatch(map.tags()[i], (*out.patterns_)[i]));
    for (const Eigen::Vector3d& corner : map.CornersInWorld(ids[i])) {
      box.extend(corner);
      out.all_tags_on_floor_ &= std::abs(corner.z()) < 1e-9;
    }
  }
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(kScribbleMarginM);
  const Eigen::Vector2d low = box.min().head<2>() - margin, high = box.max().head<2>() + margin;
  const double area_m2 = (high - low).prod() + (options.walls ? AreaOfPlanes(map) : 0);
  if (!(area_m2 * options.scribbles_per_m2 < kMostScribbles)) {
    return Error{"scribbles_per_m2: more than a million scribbles on a map of this size"};
  }
  if (options.floor) out.scribbles_ = MakeScribbles(low, high, out.tags_, options);
  if (options.walls) out.walls_ = MakeWallSheets(map, out.tags_, options);
  const std::vector<Patch> squares = MakeBoardSquares(map, options.ink_grey);
  out.scribbles_.insert(out.scribbles_.end(), squares.begin(), squares.end());
  out.AddOccluders(box.min(), box.max());
  return out;
}

void Scene::AddOccluders(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  RandomStream random(options_.random_seed, kOccluderPurpose);
  for (int i = 0; i < options_.occluders; ++i) {
    Occluder occluder;
    const double heading = random.Uniform(0, 2 * kPi), lean = random.Uniform(-0.4, 0.4);
    const double radius = options_.occluder_radius_m * random.Uniform(0.6, 1.4);
    const Eigen::Vector3d along(std::cos(heading), std::sin(heading), 0);
    const Eigen::Vector3d across(-std::sin(heading) * std::cos(lean),
                                 std::cos(heading) * std::cos(lean), std::sin(lean));
    Patch& patch = occluder.patch;
    patch.shape = Patch::Shape::kEllipse;
    patch.half_u = radius * along;
    patch.half_v = radius * random.Uniform(0.5, 1) * across;
    const double lowest_m = std::abs(patch.half_v.z()) + 0.002;  // all of it over the floor
    patch.centre << random.Uniform(low.x(), high.x()), random.Uniform(low.y(), high.y()),
        lowest_m + random.Uniform(0, options_.occluder_height_m);
    patch.grey = random.Uniform() < 0.5 ? 15 : 245;
    occluder.rate_radps = random.Uniform(0.5, 2);
    occluder.phase_rad = random.Uniform(0, 2 * kPi);
    const double way = random.Uniform(0, 2 * kPi);
    occluder.swing = options_.occluder_speed_mps / occluder.rate_radps *
                     Eigen::Vector3d(std::cos(way), std::sin(way), 0);
    occluders_.push_back(occluder);
  }
}

std::vector<Patch> Scene::OccludersAt(double t_s) const {
  std::vector<Patch> out;
  for (const Occluder& occluder : occluders_) {
    out.push_back(occluder.patch);
    out.back().centre += occluder.swing * std::sin(occluder.rate_radps * t_s + occluder.phase_rad);
  }
  return out;
}

}  // namespace tagtwist::internal
