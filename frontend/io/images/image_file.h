#pragma once
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Why an image or frame of that size is not decoded: "expected at most 100 million pixels, got
/// 32768 x 32768".
std::optional<std::string> FrameSizeFault(uint64_t width, uint64_t height, const Limits& limits);

/// 8-bit gray image from the bytes of a PNG, JPEG, TIFF, BMP, WebP or PNM; colour becomes gray, an
/// orientation in the file is not applied: pixels stay where the camera has them. Other formats,
/// whose size nobody knows before they are decoded, are refused. Errors are a short reason without
/// any name: "truncated PNG", "cannot decode". PNG and JPEG are checked for
/// wholeness first: their decoders print on stderr or return half an image.
Result<cv::Mat> DecodeGrayImage(const std::string& bytes, const Limits& limits = {});

/// Decodes an image from a file; the reason again without the name: "cannot open: No such file or
/// directory".
Result<cv::Mat> ReadGrayImage(const std::string& path, const Limits& limits = {});

/// PNG bytes of an 8-bit gray image.
Result<std::string> EncodePng(const cv::Mat& gray);

}  // namespace tagtwist::internal
