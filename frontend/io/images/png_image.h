#pragma once
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace tagtwist::internal {

/// 8-bit gray image from the bytes of a PNG, by libpng, with OpenCV's conversions: the upper eight
/// of 16 bits, 0.299, 0.587 and 0.114 of red, green and blue, no alpha. nullopt: damaged. Unlike
/// OpenCV's own decoder it prints nothing on standard error, whatever is in the file.
std::optional<cv::Mat> DecodeGrayPng(const std::string& bytes);

}  // namespace tagtwist::internal
