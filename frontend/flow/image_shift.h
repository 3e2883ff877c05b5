#pragma once
#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace tagtwist::internal {

/// How far most of an image moves to the next one [px], both 8-bit gray and of one size, by phase
/// correlation (Kuglin and Hines, 1975) of both at a hundred columns or rows: good to some pixels
/// up to a third of the image. That is where a search for points may begin.
Eigen::Vector2d EstimateShift(const cv::Mat& from, const cv::Mat& to);

}  // namespace tagtwist::internal
