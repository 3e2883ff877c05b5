#include "estimator/calibration/set_up/set_up_variants.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace tagtwist::internal {
namespace {

// Distinct values, those closer than a tenth of a tag being one.
std::vector<double> Distinct(std::vector<double> values, double size_m) {
  std::sort(values.begin(), values.end());
  std::vector<double> out;
  for (const double value : values) {
    if (out.empty() || value - out.back() > 0.1 * size_m) out.push_back(value);
  }
  return out;
}

size_t IndexOf(const std::vector<double>& values, double value) {
  size_t best = 0;
  for (size_t i = 1; i < values.size(); ++i) {
    if (std::abs(values[i] - value) < std::abs(values[best] - value)) best = i;
  }
  return best;
}

// A full grid of equal, upright tags on one plane z = const: its places, and which cell each tag of
// the map has.
struct Grid {
  std::vector<double> x_m, y_m;
  std::vector<std::pair<size_t, size_t>> cells;  // one a tag: index in x, index in y
};

std::optional<Grid> GridOf(const TagMap& map) {
  const std::vector<Tag>& tags = map.tags();
  if (tags.size() < 4) return std::nullopt;
  std::vector<double> x_m, y_m;
  for (const Tag& tag : tags) {
    const Pose& pose = tag.world_from_tag;
    const double turned = pose.rotation().angularDistance(tags[0].world_from_tag.rotation());
    const double above =
        std::abs(pose.translation().z() - tags[0].world_from_tag.translation().z());
    if (turned > 1e-3 || above > 1e-3 || std::abs(tag.size_m - tags[0].size_m) > 1e-6) {
      return std::nullopt;
    }
    x_m.push_back(pose.translation().x());
    y_m.push_back(pose.translation().y());
  }
  Grid out{Distinct(x_m, tags[0].size_m), Distinct(y_m, tags[0].size_m), {}};
  if (out.x_m.size() * out.y_m.size() != tags.size()) return std::nullopt;
  for (size_t i = 0; i < tags.size(); ++i) {
    out.cells.emplace_back(IndexOf(out.x_m, x_m[i]), IndexOf(out.y_m, y_m[i]));
  }
  return out;
}

// The map with its ids dealt out over the same grid in another way. `transposed`: the ids that ran
// along x run along y. False where the grid has no such way.
bool Redeal(const TagMap& map, const Grid& grid, bool flip_x, bool flip_y, bool transposed,
            TagMap* out) {
  const size_t columns = grid.x_m.size(), rows = grid.y_m.size();
  const bool x_is_fast = grid.cells[1].first != grid.cells[0].first;
  std::vector<Tag> tags = map.tags();
  for (size_t i = 0; i < tags.size(); ++i) {
    auto [x, y] = grid.cells[i];
    if (transposed) {
      const size_t rank = x_is_fast ? y * columns + x : x * rows + y;
      x = x_is_fast ? rank / rows : rank % columns;
      y = x_is_fast ? rank % rows : rank / columns;
    }
    if (x >= columns || y >= rows) return false;
    if (flip_x) x = columns - 1 - x;
    if (flip_y) y = rows - 1 - y;
    Pose& pose = tags[i].world_from_tag;
    pose = MakePose(pose.rotation(), {grid.x_m[x], grid.y_m[y], pose.translation().z()});
  }
  *out = TagMap(map.family(), std::move(tags));
  return true;
}

double MeanStep(const std::vector<double>& places) {
  return places.size() < 2
             ? 0
             : (places.back() - places.front()) / static_cast<double>(places.size() - 1);
}

// The map with as many tags along x as it has along y and the other way round, the ids still
// running along the same side. `gaps`: with the places of the other side, too, else at the mean
// distances of the same.
TagMap Exchanged(const TagMap& map, const Grid& grid, bool gaps) {
  const size_t along_x = grid.x_m.size(), along_y = grid.y_m.size();
  const bool x_is_fast = grid.cells[1].first != grid.cells[0].first;
  const double step_x = MeanStep(grid.x_m), step_y = MeanStep(grid.y_m);
  std::vector<Tag> tags = map.tags();
  for (size_t i = 0; i < tags.size(); ++i) {
    const auto [x, y] = grid.cells[i];
    const size_t rank = x_is_fast ? y * along_x + x : x * along_y + y;
    const size_t new_x = x_is_fast ? rank % along_y : rank / along_x;
    const size_t new_y = x_is_fast ? rank / along_y : rank % along_x;
    Pose& pose = tags[i].world_from_tag;
    const double x_m = gaps ? grid.y_m[new_x] : step_x * static_cast<double>(new_x);
    const double y_m = gaps ? grid.x_m[new_y] : step_y * static_cast<double>(new_y);
    pose = MakePose(pose.rotation(), {x_m, y_m, pose.translation().z()});
  }
  return TagMap(map.family(), std::move(tags));
}

}  // namespace

std::vector<SetUpVariant> SetUpVariants(const TagMap& map) {
  std::vector<SetUpVariant> out;
  const auto grid = GridOf(map);
  if (!grid) return out;
  const bool oblong =
      grid->x_m.size() != grid->y_m.size() && grid->x_m.size() > 1 && grid->y_m.size() > 1;
  for (int gaps = 0; oblong && gaps < 2; ++gaps) {
    SetUpVariant variant;
    variant.map = Exchanged(map, *grid, gaps != 0);
    variant.fact = "The grid has its numbers of rows and columns exchanged.";
    variant.advice = "Exchange rows and columns in the map, with their gaps.";
    out.push_back(std::move(variant));
  }
  for (int way = 1; way < 8; ++way) {
    const bool flip_x = (way & 1) != 0, flip_y = (way & 2) != 0, transposed = (way & 4) != 0;
    SetUpVariant variant;
    if (!Redeal(map, *grid, flip_x, flip_y, transposed, &variant.map)) continue;
    variant.fact = transposed ? "The ids run along the other side of the grid than the map says: "
                                "rows stand for columns."
                              : "The ids run the other way over the grid than the map says.";
    variant.advice = "Exchange rows and columns, or the end at which they begin, in the map.";
    out.push_back(std::move(variant));
  }
  return out;
}

}  // namespace tagtwist::internal
