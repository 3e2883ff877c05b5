#pragma once
#include <opencv2/core/mat.hpp>

namespace tagtwist::internal {

/// Standard deviation of the noise of an 8-bit gray image [grey levels]: what a mask that planes
/// and straight edges pass unseen (Immerkaer: Fast noise variance estimation, 1996) leaves in the
/// median pixel, over some of the rows. Of an image that is texture all over it is too large.
double EstimateNoise(const cv::Mat& image);

}  // namespace tagtwist::internal
