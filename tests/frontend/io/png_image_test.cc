#include "frontend/io/images/png_image.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <opencv2/imgcodecs.hpp>

#include "frontend/io/images/image_file.h"

namespace tagtwist::internal::png_image_test {
namespace {

cv::Mat Pattern(int type) {
  cv::Mat out(13, 37, type);
  cv::RNG random(5);
  random.fill(out, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
  return out;
}

std::string Encoded(const cv::Mat& image, const std::vector<int>& how = {}) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", image, bytes, how);
  return {bytes.begin(), bytes.end()};
}

TEST(PngImage, HasThePixelsOfOpenCvsDecoder) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3}) {
    for (const std::vector<int>& how :
         {std::vector<int>{}, std::vector<int>{cv::IMWRITE_PNG_BILEVEL, 1}}) {
      if (!how.empty() && type != CV_8UC1) continue;
      const std::string bytes = Encoded(Pattern(type), how);
      const auto image = DecodeGrayPng(bytes);
      ASSERT_TRUE(image) << type;
      const cv::Mat expected =
          cv::imdecode(std::vector<char>(bytes.begin(), bytes.end()), cv::IMREAD_GRAYSCALE);
      ASSERT_EQ(image->size(), expected.size());
      EXPECT_EQ(cv::norm(*image, expected, cv::NORM_INF), 0) << type;
    }
  }
}

TEST(PngImage, CutOnesAreRefused) {
  const std::string bytes = Encoded(Pattern(CV_8UC1));
  for (size_t size = 0; size + 12 < bytes.size(); ++size) {
    EXPECT_FALSE(DecodeGrayPng(bytes.substr(0, size))) << size;
  }
}

std::string Chunk(const std::string& kind, const std::string& body) {
  const auto big_endian = [](uint64_t value) {
    return std::string{char(value >> 24), char(value >> 16), char(value >> 8), char(value)};
  };
  const std::string content = kind + body;
  return big_endian(body.size()) + content +
         big_endian(crc32(0, reinterpret_cast<const Bytef*>(content.data()), uInt(content.size())));
}

// libpng and OpenCV print of their own accord what they find wrong.
TEST(PngImage, NothingIsPrintedOfBadImages) {
  const std::string head = std::string("\x89PNG\r\n\x1a\n") +
                           Chunk("IHDR", std::string("\0\0\0\x40\0\0\0\x40\x08\0\0\0\0", 13));
  const std::vector<std::string> bad = {
      head + Chunk("zTXt", "x") + Chunk("IEND", ""),
      head + Chunk("IDAT", "no deflated rows") + Chunk("IEND", ""),
      head + Chunk("sRGB", "too many bytes") + Chunk("IDAT", "\x78\x9c") + Chunk("IEND", ""),
      "P5 -5 -5 255\n" + std::string(40, 'x'),
      "P5 64 64 255\n" + std::string(40, 'x'),
      "P2 64 64 99999\n" + std::string(9000, '1'),
      "P6",
  };
  for (const std::string& bytes : bad) {
    testing::internal::CaptureStderr();
    EXPECT_FALSE(DecodeGrayImage(bytes));
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  }
}

}  // namespace
}  // namespace tagtwist::internal::png_image_test
