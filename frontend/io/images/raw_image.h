#pragma once
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// An image as it lies in memory.
struct RawImage {
  std::string encoding;  // as ROS names it: mono8, bgr8, bayer_rggb8, ...
  uint32_t width = 0, height = 0;
  uint32_t step = 0;  // bytes of a row
  bool is_bigendian = false;
  const std::vector<uint8_t>* data = nullptr;
};

/// 8-bit gray: of colours their luminance, of 16 bits the upper
/// eight of those in use (10, 12 or 16 by the largest number of the image). Errors are a reason
/// without any name: "encoding \"yuv422\": expected one of mono8, ...", "expected 90240 bytes, got
/// 12".
Result<cv::Mat> GrayFromRaw(const RawImage& raw);

}  // namespace tagtwist::internal
