#pragma once
#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace tagtwist::internal {

constexpr int kCornerCellPx = 32;  // of the grid that spreads corners over the image

struct CornerPickOptions {
  int n_wanted = 0;            // corners at most
  double min_distance_px = 6;  // between corners, and from `taken`
  double border_px = 3;        // of the image, without corners
  int threshold = 20;          // FAST's contrast [gray]
  int most_in_cell = 1000000;  // of a cell of the grid, those taken included
};

struct CornerPick {
  std::vector<Eigen::Vector2d> corners;
  int n_found = 0;  // FAST corners before the choice
};

/// FAST corners of an 8-bit gray image, spread over it: the strongest of each cell of a grid come
/// first, then the next of each, and so on. `taken` are points that the choice keeps away from.
CornerPick PickCorners(const cv::Mat& image, const std::vector<Eigen::Vector2d>& taken,
                       const CornerPickOptions& options);

}  // namespace tagtwist::internal
