#include "frontend/io/images/image_file.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "frontend/base/files/input_file.h"
#include "frontend/io/images/image_header.h"
#include "frontend/io/images/png_image.h"

namespace tagtwist::internal {
namespace {

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";

bool IsPng(std::string_view bytes) {
  return bytes.substr(0, kPngSignature.size()) == kPngSignature;
}

uint32_t BigEndian32(std::string_view bytes) {
  uint32_t value = 0;
  for (const char c : bytes.substr(0, 4)) value = value << 8 | static_cast<unsigned char>(c);
  return value;
}

// Walks the chunks (length, type, data, checksum) to the end mark.
std::optional<std::string> PngFault(std::string_view bytes) {
  bytes.remove_prefix(kPngSignature.size());
  for (bool first = true; bytes.size() >= 12; first = false) {
    const uint32_t length = BigEndian32(bytes);
    if (length > bytes.size() - 12) break;
    const std::string_view body = bytes.substr(4, 4 + static_cast<size_t>(length));
    const auto checksum =
        ::crc32_z(0, reinterpret_cast<const unsigned char*>(body.data()), body.size());
    if (checksum != BigEndian32(bytes.substr(4 + body.size()))) return "damaged PNG";
    const std::string_view type = body.substr(0, 4);
    if (first != (type == "IHDR")) return "damaged PNG";
    if (first && length < 13) return "damaged PNG";
    if (type == "IEND") return std::nullopt;
    bytes.remove_prefix(8 + body.size());
  }
  return "truncated PNG";
}

std::optional<std::string> FormatFault(std::string_view bytes) {
  if (bytes.empty()) return "empty file";
  if (IsPng(bytes)) return PngFault(bytes);
  if (bytes.substr(0, 3) == "\xFF\xD8\xFF") {
    // The end mark follows the last scan; bytes may follow it, and a preview have marks of its own.
    const size_t scan = bytes.rfind("\xFF\xDA"), end = bytes.rfind("\xFF\xD9");
    const bool whole =
        scan != std::string_view::npos && end != std::string_view::npos && end > scan;
    if (!whole) return "truncated JPEG";
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> FrameSizeFault(uint64_t width, uint64_t height, const Limits& limits) {
  const auto most = static_cast<uint64_t>(limits.frame_pixels);
  if (width == 0 || height == 0 || width <= most / height) return std::nullopt;
  return "expected at most " + std::to_string(most / 1'000'000) + " million pixels, got " +
         std::to_string(width) + " x " + std::to_string(height) + RaisesLimit("frame_pixels");
}

Result<cv::Mat> DecodeGrayImage(const std::string& bytes, const Limits& limits) {
  if (const auto fault = FormatFault(bytes)) return Error{*fault};
  const auto header = ReadImageHeader(bytes);
  if (!header && BeginsAsPnm(bytes)) return Error{"damaged PNM"};
  // OpenCV tries what knows of more formats, in some of which a few bytes are an image of any size;
  // its reader of DICOM ends the process at a damaged one.
  const bool is_dicom = bytes.compare(std::min<size_t>(128, bytes.size()), 4, "DICM") == 0;
  if (!header || is_dicom)
    return Error{"cannot decode, no sound PNG, JPEG, TIFF, BMP, WebP or PNM"};
  if (const auto fault = FrameSizeFault(header->width, header->height, limits)) {
    return Error{*fault};
  }
  if (header->least_bytes > bytes.size()) return Error{"truncated PNM"};
  if (IsPng(bytes)) {
    auto png = DecodeGrayPng(bytes);
    return png ? Result<cv::Mat>(std::move(*png)) : Error{"damaged PNG"};
  }
  cv::Mat image;
  try {
    const cv::Mat view(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
    image = cv::imdecode(view, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) return Error{"cannot decode"};
  // A file may say one thing at its beginning, and another where the decoder looks.
  if (const auto fault = FrameSizeFault(static_cast<uint64_t>(image.cols),
                                        static_cast<uint64_t>(image.rows), limits)) {
    return Error{*fault};
  }
  return image;
}

Result<cv::Mat> ReadGrayImage(const std::string& path, const Limits& limits) {
  // A pipe among thousands of images would be waited for each time.
  if (const auto regular = CheckRegularFile(path); !regular) {
    return Error{regular.error().message.substr(path.size() + 2)};
  }
  const auto bytes = ReadWholeFile(path, limits);
  if (!bytes) return Error{bytes.error().message.substr(path.size() + 2)};  // without "path: "
  return DecodeGrayImage(*bytes, limits);
}

Result<std::string> EncodePng(const cv::Mat& gray) {
  std::vector<unsigned char> bytes;
  try {
    if (gray.type() == CV_8UC1 && !gray.empty() && cv::imencode(".png", gray, bytes)) {
      return std::string(bytes.begin(), bytes.end());
    }
  } catch (const cv::Exception&) {
    return Error{"cannot encode the image"};
  }
  return Error{"expected an 8-bit gray image"};
}

}  // namespace tagtwist::internal
