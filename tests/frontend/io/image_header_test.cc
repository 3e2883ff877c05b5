#include "frontend/io/images/image_header.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "frontend/io/images/image_file.h"

namespace tagtwist::internal::image_header_test {
namespace {

using ::testing::HasSubstr;

std::string Encoded(const std::string& ending, int width, int height) {
  std::vector<unsigned char> bytes;
  cv::imencode(ending, cv::Mat(height, width, CV_8UC1, cv::Scalar(7)), bytes);
  return {bytes.begin(), bytes.end()};
}

TEST(ImageHeader, TellsTheSizeThatIsDecoded) {
  for (const char* ending : {".png", ".jpg", ".tiff", ".bmp", ".pgm", ".webp"}) {
    const std::string bytes = Encoded(ending, 123, 45);
    const auto header = ReadImageHeader(bytes);
    ASSERT_TRUE(header) << ending;
    EXPECT_EQ(header->width, 123u) << ending;
    EXPECT_EQ(header->height, 45u) << ending;
    for (size_t size = 0; size < bytes.size(); ++size) ReadImageHeader(bytes.substr(0, size));
  }
  EXPECT_FALSE(ReadImageHeader("no image, but long enough for one to be there"));
}

TEST(ImageHeader, AbsurdSizesAreNotDecoded) {
  Limits limits, raised;
  limits.frame_pixels = 5000;
  raised.frame_pixels = 10000;
  for (const char* ending : {".png", ".jpg", ".tiff", ".bmp", ".pgm", ".webp"}) {
    const std::string bytes = Encoded(ending, 123, 45);
    const auto refused = DecodeGrayImage(bytes, limits);
    ASSERT_FALSE(refused) << ending;
    EXPECT_THAT(refused.error().message, HasSubstr("got 123 x 45"));
    EXPECT_TRUE(DecodeGrayImage(bytes, raised)) << ending;
  }
  const auto huge = DecodeGrayImage("P5 32768 32768 255\n" + std::string(40, 'x'));
  ASSERT_FALSE(huge);
  EXPECT_THAT(huge.error().message, HasSubstr("at most 100 million pixels, got 32768 x 32768"));
}

}  // namespace
}  // namespace tagtwist::internal::image_header_test
