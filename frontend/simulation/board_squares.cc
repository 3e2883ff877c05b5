#include "frontend/simulation/board_squares.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "frontend/types/tag_family.h"

namespace tagtwist::internal {
namespace {

// Distance of a tag to the nearest one beside it, printed the same way up; infinite without one.
double GapBeside(const Tag& tag, const TagMap& map) {
  constexpr double kAligned = 0.01;  // of the tag's side
  const Pose tag_from_world = Inverse(tag.world_from_tag);
  double gap_m = std::numeric_limits<double>::infinity();
  for (const Tag& other : map.tags()) {
    const Pose tag_from_other = tag_from_world * other.world_from_tag;
    const Eigen::Vector3d step = tag_from_other.translation();
    const double along_m = step.head<2>().cwiseAbs().maxCoeff();
    const double across_m = std::hypot(step.head<2>().cwiseAbs().minCoeff(), step.z());
    const Eigen::Vector3d right = tag_from_other.rotation() * Eigen::Vector3d::UnitX();
    const bool turned = !((right - Eigen::Vector3d::UnitX()).norm() < kAligned);
    if (other.id == tag.id || turned || !(across_m < kAligned * tag.size_m)) continue;
    gap_m = std::min(gap_m, along_m - 0.5 * (tag.size_m + other.size_m));
  }
  return gap_m;
}

bool IsThere(const Patch& square, const std::vector<Patch>& squares) {
  return std::any_of(squares.begin(), squares.end(), [&](const Patch& other) {
    return (square.centre - other.centre).norm() < 0.1 * square.half_u.norm();
  });
}

}  // namespace

std::vector<Patch> MakeBoardSquares(const TagMap& map, double ink_grey) {
  std::vector<Patch> out;
  if (map.family() != kKalibrFamily) return out;
  for (const Tag& tag : map.tags()) {
    const double gap_m = GapBeside(tag, map);
    if (!(gap_m > 0 && gap_m < tag.size_m)) continue;
    const double away_m = 0.5 * (tag.size_m + gap_m);
    for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}}) {
      Patch square;
      square.centre = tag.world_from_tag * Eigen::Vector3d(x * away_m, y * away_m, 0);
      square.half_u = tag.world_from_tag.rotation() * Eigen::Vector3d(0.5 * gap_m, 0, 0);
      square.half_v = tag.world_from_tag.rotation() * Eigen::Vector3d(0, 0.5 * gap_m, 0);
      square.grey = ink_grey;
      if (!IsThere(square, out)) out.push_back(square);
    }
  }
  return out;
}

}  // namespace tagtwist::internal
