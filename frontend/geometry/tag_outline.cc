#include "frontend/geometry/tag_outline.h"

#include "frontend/geometry/cross.h"

namespace tagtwist::internal {

double MeanSidePx(const TagDetection& tag) {
  double sum = 0;
  for (size_t c = 0; c < 4; ++c) sum += (tag.corners[(c + 1) % 4] - tag.corners[c]).norm();
  return sum / 4;
}

std::array<Eigen::Vector2d, 4> GrownOutline(const TagDetection& tag, double margin_of_side) {
  const auto& c = tag.corners;
  const Eigen::Vector2d diagonal = c[2] - c[0];
  const double along = Cross(c[1] - c[0], c[3] - c[1]) / Cross(diagonal, c[3] - c[1]);
  const Eigen::Vector2d centre = c[0] + along * diagonal;
  const double growth = 1 + 2 * margin_of_side;
  std::array<Eigen::Vector2d, 4> outline;
  for (size_t i = 0; i < 4; ++i) outline[i] = centre + growth * (c[i] - centre);
  return outline;
}

bool IsInside(const Eigen::Vector2d& pixel, const std::array<Eigen::Vector2d, 4>& outline) {
  int n_left = 0;
  for (size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d& from = outline[i];
    if (Cross(outline[(i + 1) % 4] - from, pixel - from) > 0) ++n_left;
  }
  return n_left == 0 || n_left == 4;
}

const TagDetection* TagUnder(const Eigen::Vector2d& pixel, const std::vector<TagDetection>& tags,
                             double margin_of_side) {
  for (const TagDetection& tag : tags) {
    if (IsInside(pixel, GrownOutline(tag, margin_of_side))) return &tag;
  }
  return nullptr;
}

}  // namespace tagtwist::internal
