#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// The white cell around a tag36h11, with half a cell to spare, as a fraction of the tag's side of
/// eight cells.
constexpr double kWhiteMarginOfSide = 1.5 / 8;

/// Of the tag's four sides in the image.
double MeanSidePx(const TagDetection& tag);

/// A tag's outline in the image, its corners moved away from where the diagonals meet so that the
/// sides lie `margin_of_side` times a side further out. Exact for a tag seen face-on.
std::array<Eigen::Vector2d, 4> GrownOutline(const TagDetection& tag, double margin_of_side);

/// True when the pixel is inside a convex outline, in either order of its corners.
bool IsInside(const Eigen::Vector2d& pixel, const std::array<Eigen::Vector2d, 4>& outline);

/// The first tag whose grown outline holds the pixel, or nullptr.
const TagDetection* TagUnder(const Eigen::Vector2d& pixel, const std::vector<TagDetection>& tags,
                             double margin_of_side);

}  // namespace tagtwist::internal
