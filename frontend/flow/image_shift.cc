#include "frontend/flow/image_shift.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace tagtwist::internal {
namespace {

cv::Mat Coarse(const cv::Mat& image, cv::Size size) {
  cv::Mat small, out;
  cv::resize(image, small, size, 0, 0, cv::INTER_AREA);
  small.convertTo(out, CV_32F);
  return out;
}

}  // namespace

Eigen::Vector2d EstimateShift(const cv::Mat& from, const cv::Mat& to) {
  constexpr int kCoarsePx = 100;
  const int coarser = std::max(1, std::max(from.cols, from.rows) / kCoarsePx);
  const cv::Size size(std::max(1, from.cols / coarser), std::max(1, from.rows / coarser));
  if (std::min(size.width, size.height) < 8) return Eigen::Vector2d::Zero();
  cv::Mat window;  // the borders are no edges
  cv::createHanningWindow(window, size, CV_32F);
  const cv::Point2d shift = cv::phaseCorrelate(Coarse(from, size), Coarse(to, size), window);
  return {shift.x * from.cols / size.width, shift.y * from.rows / size.height};
}

}  // namespace tagtwist::internal
