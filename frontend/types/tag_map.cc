#include "frontend/types/tag_map.h"

#include <cmath>
#include <utility>

#include "frontend/base/number_text.h"

namespace tagtwist {

using namespace internal;
namespace {

// Why a tag's side cannot be that, without the name of the value.
std::optional<std::string> TagSizeProblem(double size_m) {
  constexpr double kLeastM = 1e-6, kMostM = 1e6;  // beyond, squares of it are no numbers any more
  if (size_m >= kLeastM && size_m <= kMostM) return std::nullopt;
  return (size_m > 0 ? "expected 1e-6 to 1e6 m, got " : "expected > 0, got ") +
         FormatNumber(size_m);
}

}  // namespace

std::array<Eigen::Vector3d, 4> TagCornersInWorld(const Tag& tag) {
  const double h = 0.5 * tag.size_m, b = tag.bend_m;
  return {tag.world_from_tag * Eigen::Vector3d(-h, -h, b),
          tag.world_from_tag * Eigen::Vector3d(h, -h, -b),
          tag.world_from_tag * Eigen::Vector3d(h, h, b),
          tag.world_from_tag * Eigen::Vector3d(-h, h, -b)};
}

std::optional<std::string> BendProblem(const Tag& tag) {
  if (std::abs(tag.bend_m) < 0.25 * tag.size_m) return std::nullopt;
  return "bend_m: expected less than a quarter of the side of " + std::to_string(tag.size_m) +
         " m, got " + std::to_string(tag.bend_m);
}

TagMap::TagMap(std::string family, std::vector<Tag> tags)
    : family_(std::move(family)), tags_(std::move(tags)) {
  corners_.reserve(tags_.size());
  for (size_t i = 0; i < tags_.size(); ++i) {
    corners_.push_back(TagCornersInWorld(tags_[i]));
    index_.emplace(tags_[i].id, i);
  }
}

const Tag* TagMap::Find(int id) const {
  const auto it = index_.find(id);
  return it == index_.end() ? nullptr : &tags_[it->second];
}

const std::array<Eigen::Vector3d, 4>& TagMap::CornersInWorld(int id) const {
  return corners_[index_.at(id)];
}

std::optional<std::string> TagMap::Problem() const {
  if (tags_.empty()) return "expected at least one tag";
  for (size_t i = 0; i < tags_.size(); ++i) {
    const std::string name = "tag " + std::to_string(tags_[i].id);
    if (tags_[i].id < 0) return name + ": expected an id >= 0";
    if (index_.at(tags_[i].id) != i) return name + ": listed twice";
    if (const auto problem = TagSizeProblem(tags_[i].size_m)) return name + ": size_m: " + *problem;
    if (const auto problem = BendProblem(tags_[i])) return name + ": " + *problem;
    if (!tags_[i].world_from_tag.params.allFinite()) return name + ": expected a finite pose";
  }
  return std::nullopt;
}

std::optional<std::string> TagGrid::Problem() const {
  if (first_id < 0) return "first_id: expected >= 0, got " + std::to_string(first_id);
  if (rows < 1) return "rows: expected >= 1, got " + std::to_string(rows);
  if (columns < 1) return "columns: expected >= 1, got " + std::to_string(columns);
  if (const auto problem = TagSizeProblem(tag_size_m)) return "tag_size_m: " + *problem;
  const auto gaps_problem = [](const std::vector<double>& gaps, int lines,
                               const std::string& key) -> std::optional<std::string> {
    if (gaps.size() + 1 != static_cast<size_t>(lines)) {
      return key + ": expected " + std::to_string(lines - 1) + " gaps, got " +
             std::to_string(gaps.size());
    }
    for (const double gap : gaps) {
      if (!(gap >= 0) || !std::isfinite(gap)) {
        return key + ": expected gaps >= 0, got " + std::to_string(gap);
      }
    }
    return std::nullopt;
  };
  if (auto problem = gaps_problem(row_gaps_m, rows, "row_gaps_m")) return problem;
  return gaps_problem(column_gaps_m, columns, "column_gaps_m");
}

TagMap MakeTagMap(const TagGrid& grid) {
  // As printed the tag's x is the world's y and its y is the world's -x: a quarter turn about z.
  const Eigen::Quaterniond world_from_tag(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  std::vector<Tag> tags;
  double y = 0.5 * grid.tag_size_m;
  for (int column = 0; column < grid.columns; ++column) {
    double x = 0.5 * grid.tag_size_m;
    for (int row = 0; row < grid.rows; ++row) {
      tags.push_back({grid.first_id + grid.rows * column + row, MakePose(world_from_tag, {x, y, 0}),
                      grid.tag_size_m});
      if (row + 1 < grid.rows) x += grid.tag_size_m + grid.row_gaps_m[static_cast<size_t>(row)];
    }
    if (column + 1 < grid.columns) {
      y += grid.tag_size_m + grid.column_gaps_m[static_cast<size_t>(column)];
    }
  }
  return TagMap(grid.family, std::move(tags));
}

}  // namespace tagtwist
