#include "frontend/io/images/raw_image.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

namespace tagtwist::internal {
namespace {

constexpr int kAsItIs = -1;
constexpr uint32_t kLongestSidePx = 1U << 16;

struct Encoding {
  const char* name;
  uint32_t channels, bytes;  // a channel's
  int to_gray;               // OpenCV's code
};

// OpenCV calls a Bayer pattern by its second row, from the second column on.
constexpr std::array<Encoding, 21> kEncodings = {{
    {"mono8", 1, 1, kAsItIs},
    {"8UC1", 1, 1, kAsItIs},
    {"mono16", 1, 2, kAsItIs},
    {"16UC1", 1, 2, kAsItIs},
    {"bgr8", 3, 1, cv::COLOR_BGR2GRAY},
    {"8UC3", 3, 1, cv::COLOR_BGR2GRAY},
    {"rgb8", 3, 1, cv::COLOR_RGB2GRAY},
    {"bgra8", 4, 1, cv::COLOR_BGRA2GRAY},
    {"rgba8", 4, 1, cv::COLOR_RGBA2GRAY},
    {"bayer_rggb8", 1, 1, cv::COLOR_BayerBG2GRAY},
    {"bayer_bggr8", 1, 1, cv::COLOR_BayerRG2GRAY},
    {"bayer_gbrg8", 1, 1, cv::COLOR_BayerGR2GRAY},
    {"bayer_grbg8", 1, 1, cv::COLOR_BayerGB2GRAY},
    {"8UC4", 4, 1, cv::COLOR_BGRA2GRAY},
    {"bayer_rggb16", 1, 2, cv::COLOR_BayerBG2GRAY},
    {"bayer_bggr16", 1, 2, cv::COLOR_BayerRG2GRAY},
    {"bayer_gbrg16", 1, 2, cv::COLOR_BayerGR2GRAY},
    {"bayer_grbg16", 1, 2, cv::COLOR_BayerGB2GRAY},
    {"yuv422", 2, 1, cv::COLOR_YUV2GRAY_UYVY},
    {"uyvy", 2, 1, cv::COLOR_YUV2GRAY_UYVY},
    {"yuv422_yuy2", 2, 1, cv::COLOR_YUV2GRAY_YUY2},
}};

uint32_t NumberAt(const RawImage& raw, const uint8_t* row, uint32_t x) {
  const uint32_t first = row[2 * static_cast<size_t>(x)],
                 second = row[2 * static_cast<size_t>(x) + 1];
  return raw.is_bigendian ? (first << 8U) | second : (second << 8U) | first;
}

// The upper eight of the bits that the numbers have: sensors of 10 and 12 bits leave the upper
// ones of 16 empty.
cv::Mat UpperBits(const RawImage& raw) {
  uint32_t largest = 0;
  for (uint32_t y = 0; y < raw.height; ++y) {
    const uint8_t* row = raw.data->data() + static_cast<size_t>(y) * raw.step;
    for (uint32_t x = 0; x < raw.width; ++x) largest = std::max(largest, NumberAt(raw, row, x));
  }
  const uint32_t shift = largest < 1U << 10U ? 2 : largest < 1U << 12U ? 4 : 8;
  cv::Mat out(static_cast<int>(raw.height), static_cast<int>(raw.width), CV_8UC1);
  for (uint32_t y = 0; y < raw.height; ++y) {
    const uint8_t* row = raw.data->data() + static_cast<size_t>(y) * raw.step;
    uint8_t* to = out.ptr<uint8_t>(static_cast<int>(y));
    for (uint32_t x = 0; x < raw.width; ++x) {
      to[x] = static_cast<uint8_t>(NumberAt(raw, row, x) >> shift);
    }
  }
  return out;
}

}  // namespace

Result<cv::Mat> GrayFromRaw(const RawImage& raw) {
  const auto* encoding =
      std::find_if(kEncodings.begin(), kEncodings.end(),
                   [&](const Encoding& candidate) { return raw.encoding == candidate.name; });
  if (encoding == kEncodings.end()) {
    std::string known;
    for (const Encoding& each : kEncodings)
      known += (known.empty() ? "" : ", ") + std::string(each.name);
    return Error{"encoding: expected one of " + known + ", got another"};
  }
  if (raw.width < 2 || raw.height < 2 || raw.width > kLongestSidePx ||
      raw.height > kLongestSidePx) {
    return Error{"an image of " + std::to_string(raw.width) + " x " + std::to_string(raw.height) +
                 " px"};
  }
  const uint64_t row_bytes = uint64_t{raw.width} * encoding->channels * encoding->bytes;
  const uint64_t bytes = uint64_t{raw.height} * raw.step;
  if (raw.step < row_bytes) {
    return Error{"expected rows of " + std::to_string(row_bytes) + " bytes, got " +
                 std::to_string(raw.step)};
  }
  if (raw.data->size() < bytes) {
    return Error{"expected " + std::to_string(bytes) + " bytes, got " +
                 std::to_string(raw.data->size())};
  }
  const cv::Mat upper = encoding->bytes == 2 ? UpperBits(raw) : cv::Mat();
  if (encoding->bytes == 2 && encoding->to_gray == kAsItIs) return upper;
  const cv::Mat view = encoding->bytes == 2
                           ? upper
                           : cv::Mat(static_cast<int>(raw.height), static_cast<int>(raw.width),
                                     CV_8UC(static_cast<int>(encoding->channels)),
                                     const_cast<uint8_t*>(raw.data->data()), raw.step);
  cv::Mat out;
  if (encoding->to_gray == kAsItIs) {
    out = view.clone();
  } else {
    cv::cvtColor(view, out, encoding->to_gray);
  }
  return out;
}

}  // namespace tagtwist::internal
