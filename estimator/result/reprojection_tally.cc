#include "estimator/result/reprojection_tally.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace tagtwist::internal {
namespace {

constexpr int64_t kBlockNs = 1'000'000'000;

void AddError(const Eigen::Vector2d& error, RegionErrors* out) {
  out->squares.Add(error.squaredNorm());
  out->u.Add(error.x());
  out->v.Add(error.y());
}

size_t CellOf(const Camera& camera, const Eigen::Vector2d& pixel) {
  constexpr int kColumns = ReprojectionErrorsByPlace::kColumns;
  constexpr int kRows = ReprojectionErrorsByPlace::kRows;
  const int column = static_cast<int>((pixel.x() + 0.5) / camera.width * kColumns);
  const int row = static_cast<int>((pixel.y() + 0.5) / camera.height * kRows);
  return static_cast<size_t>(std::clamp(row, 0, kRows - 1) * kColumns +
                             std::clamp(column, 0, kColumns - 1));
}

size_t RingOf(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d centre(camera.cx, camera.cy);
  const Eigen::Vector2d farthest(std::max(camera.cx, camera.width - 1 - camera.cx),
                                 std::max(camera.cy, camera.height - 1 - camera.cy));
  const double share = (pixel - centre).norm() / farthest.norm();
  constexpr auto kRings = static_cast<double>(ReprojectionErrorsByPlace::kRings);
  return static_cast<size_t>(std::clamp(share * kRings, 0.0, kRings - 1));
}

// Derivative of the pixel by the place in the tag's frame [px/m], the same all over the tag.
Eigen::Matrix2d PixelsByPlace(const std::array<Eigen::Vector2d, 4>& corners, double size_m) {
  Eigen::Matrix2d out;
  out << corners[1] + corners[2] - corners[0] - corners[3],
      corners[2] + corners[3] - corners[0] - corners[1];
  return out / (2 * size_m);
}

void AddInterval(const TagErrors::Interval& next, TagErrors* tag) {
  if (tag->seen.empty() || next.first_ns - tag->seen.back().last_ns > tag->bridged_ns) {
    tag->seen.push_back(next);
  }
  tag->seen.back().last_ns = next.last_ns;
}

void AddSighting(int64_t t_ns, TagErrors* tag) {
  constexpr size_t kMostIntervals = 512;
  AddInterval({t_ns, t_ns}, tag);
  while (tag->seen.size() > kMostIntervals) {
    tag->bridged_ns *= 2;
    const std::vector<TagErrors::Interval> all = std::move(tag->seen);
    tag->seen.clear();
    for (const TagErrors::Interval& interval : all) AddInterval(interval, tag);
  }
}

}  // namespace

void ReprojectionTally::CloseBlock() {
  errors_.squares.CloseBlock();
  for (RegionErrors& cell : errors_.cells) cell.CloseBlock();
  for (RegionErrors& ring : errors_.rings) ring.CloseBlock();
  for (auto& [id, tag] : errors_.tags) tag.CloseBlock();
}

void ReprojectionTally::AddTag(const Camera& camera, const TagMap& map, int64_t t_ns,
                               const Pose& cam_from_world, const TagDetection& tag) {
  TagErrors& of_tag = errors_.tags[tag.id];
  AddSighting(t_ns, &of_tag);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  const auto& corners = map.CornersInWorld(tag.id);
  for (size_t c = 0; c < 4; ++c) {
    Eigen::Vector2d pixel;
    if (!camera.Project(cam_from_world * corners[c], &pixel)) return;
    const Eigen::Vector2d error = tag.corners[c] - pixel;
    mean += 0.25 * error;
    errors_.squares.Add(error.squaredNorm());
    of_tag.squares.Add(error.squaredNorm());
    AddError(error, &errors_.cells[CellOf(camera, tag.corners[c])]);
    AddError(error, &errors_.rings[RingOf(camera, tag.corners[c])]);
  }
  const Eigen::Matrix2d by_place = PixelsByPlace(tag.corners, map.Find(tag.id)->size_m);
  const double area = std::abs(by_place.determinant());
  if (!(area > 0)) return;
  const Eigen::Vector2d shift_m = by_place.inverse() * mean;
  of_tag.x_m.Add(shift_m.x());
  of_tag.y_m.Add(shift_m.y());
  of_tag.px_per_m.Add(std::sqrt(area));
}

void ReprojectionTally::Add(const Camera& camera, const TagMap& map, int64_t t_ns,
                            const Pose& cam_from_world, const std::vector<TagDetection>& tags) {
  if (!block_ns_ || t_ns - *block_ns_ >= kBlockNs) {
    CloseBlock();
    block_ns_ = t_ns;
  }
  for (const TagDetection& tag : tags) AddTag(camera, map, t_ns, cam_from_world, tag);
}

ReprojectionErrorsByPlace ReprojectionTally::Errors() const {
  ReprojectionTally all = *this;
  all.CloseBlock();
  return std::move(all.errors_);
}

}  // namespace tagtwist::internal
