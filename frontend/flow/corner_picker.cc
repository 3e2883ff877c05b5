#include "frontend/flow/corner_picker.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <tuple>

namespace tagtwist::internal {
namespace {

// Points on a grid of cells as wide as the least distance, so that only neighbours are asked.
class Spacing {
 public:
  Spacing(cv::Size size, double distance_px)
      : distance_px_(distance_px),
        columns_(static_cast<int>(size.width / distance_px) + 1),
        rows_(static_cast<int>(size.height / distance_px) + 1),
        cells_(static_cast<size_t>(columns_) * static_cast<size_t>(rows_)) {}

  bool IsFree(const Eigen::Vector2d& point) const {
    const int column = Column(point), row = Row(point);
    for (int r = std::max(row - 1, 0); r <= std::min(row + 1, rows_ - 1); ++r) {
      for (int c = std::max(column - 1, 0); c <= std::min(column + 1, columns_ - 1); ++c) {
        for (const Eigen::Vector2d& other : cells_[Index(r, c)]) {
          if ((other - point).squaredNorm() < distance_px_ * distance_px_) return false;
        }
      }
    }
    return true;
  }
  void Add(const Eigen::Vector2d& point) {
    cells_[Index(Row(point), Column(point))].push_back(point);
  }

 private:
  int Column(const Eigen::Vector2d& point) const {
    return std::clamp(static_cast<int>(point.x() / distance_px_), 0, columns_ - 1);
  }
  int Row(const Eigen::Vector2d& point) const {
    return std::clamp(static_cast<int>(point.y() / distance_px_), 0, rows_ - 1);
  }
  size_t Index(int row, int column) const {
    return static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  }

  double distance_px_;
  int columns_, rows_;
  std::vector<std::vector<Eigen::Vector2d>> cells_;
};

size_t CellOf(const Eigen::Vector2d& point, const cv::Mat& image) {
  const auto columns = (static_cast<size_t>(image.cols) - 1) / kCornerCellPx + 1;
  return static_cast<size_t>(point.y()) / kCornerCellPx * columns +
         static_cast<size_t>(point.x()) / kCornerCellPx;
}

// Strongest first; the order is total, so that it does not depend on the sort.
bool Stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  return std::make_tuple(-a.response, a.pt.y, a.pt.x) <
         std::make_tuple(-b.response, b.pt.y, b.pt.x);
}

// FAST corners off the border, by cell, strongest first.
std::vector<std::vector<cv::KeyPoint>> CornersByCell(const cv::Mat& image,
                                                     const CornerPickOptions& options,
                                                     CornerPick* pick) {
  std::vector<cv::KeyPoint> found;
  cv::FAST(image, found, options.threshold, /*nonmaxSuppression=*/true);
  pick->n_found = static_cast<int>(found.size());
  std::vector<std::vector<cv::KeyPoint>> cells(
      CellOf(Eigen::Vector2d(image.cols - 1, image.rows - 1), image) + 1);
  const auto margin = static_cast<float>(options.border_px);
  for (const cv::KeyPoint& corner : found) {
    if (corner.pt.x < margin || corner.pt.y < margin ||
        corner.pt.x > static_cast<float>(image.cols - 1) - margin ||
        corner.pt.y > static_cast<float>(image.rows - 1) - margin) {
      continue;
    }
    cells[CellOf({corner.pt.x, corner.pt.y}, image)].push_back(corner);
  }
  for (auto& cell : cells) std::sort(cell.begin(), cell.end(), Stronger);
  return cells;
}

}  // namespace

CornerPick PickCorners(const cv::Mat& image, const std::vector<Eigen::Vector2d>& taken,
                       const CornerPickOptions& options) {
  CornerPick pick;
  const auto cells = CornersByCell(image, options, &pick);
  Spacing spacing(image.size(), options.min_distance_px);
  std::vector<int> n_in_cell(cells.size(), 0);
  std::vector<size_t> next(cells.size(), 0);
  for (const Eigen::Vector2d& point : taken) {
    spacing.Add(point);
    ++n_in_cell[CellOf(point, image)];
  }
  // Round n fills every cell up to n points, those taken included.
  const auto n_wanted = static_cast<size_t>(std::max(options.n_wanted, 0));
  bool more = true;
  for (int round = 1; more && round <= options.most_in_cell && pick.corners.size() < n_wanted;
       ++round) {
    more = false;
    for (size_t cell = 0; cell < cells.size() && pick.corners.size() < n_wanted; ++cell) {
      while (n_in_cell[cell] < round && next[cell] < cells[cell].size()) {
        const cv::Point2f& corner = cells[cell][next[cell]++].pt;
        const Eigen::Vector2d point(corner.x, corner.y);
        if (!spacing.IsFree(point)) continue;
        spacing.Add(point);
        pick.corners.push_back(point);
        ++n_in_cell[cell];
      }
      more = more || next[cell] < cells[cell].size();
    }
  }
  return pick;
}

}  // namespace tagtwist::internal
