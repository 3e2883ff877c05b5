#include "frontend/flow/image_noise.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace tagtwist::internal {

double EstimateNoise(const cv::Mat& image) {
  constexpr int kLargest = 16 * 255, kRowStep = 4;
  std::array<int, kLargest + 1> counts{};
  int n = 0;
  for (int y = 1; y + 1 < image.rows; y += kRowStep) {
    const auto *above = image.ptr<uchar>(y - 1), *here = image.ptr<uchar>(y),
               *below = image.ptr<uchar>(y + 1);
    const auto column = [&](int x) { return above[x] - 2 * here[x] + below[x]; };
    for (int x = 1; x + 1 < image.cols; ++x, ++n) {
      ++counts[static_cast<size_t>(std::abs(column(x - 1) - 2 * column(x) + column(x + 1)))];
    }
  }
  // Of a normal distribution the median is at 0.6745 sigma; the mask multiplies white noise by 6.
  // Within a count, as if spread evenly over it.
  int below_median = 0, at = 0;
  while (at < kLargest && 2 * (below_median + counts[static_cast<size_t>(at)]) < n) {
    below_median += counts[static_cast<size_t>(at++)];
  }
  const int here = counts[static_cast<size_t>(at)];
  const double within = here > 0 ? (0.5 * n - below_median) / here : 0;
  return std::max(0.0, at - 0.5 + within) / (0.6745 * 6);
}

}  // namespace tagtwist::internal
