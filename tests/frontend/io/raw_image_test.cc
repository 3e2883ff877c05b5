#include "frontend/io/images/raw_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace tagtwist::internal::raw_image_test {
namespace {

using ::testing::HasSubstr;

constexpr uint32_t kWidth = 6, kHeight = 4;

// Rows two bytes longer than they need be.
Result<cv::Mat> Read(const std::string& encoding, uint32_t pixel_bytes,
                     const std::vector<uint8_t>& pixel) {
  const uint32_t step = kWidth * pixel_bytes + 2;
  std::vector<uint8_t> data(step * kHeight, 77);
  for (uint32_t y = 0; y < kHeight; ++y) {
    for (uint32_t x = 0; x < kWidth; ++x) {
      std::copy(pixel.begin(), pixel.end(), data.begin() + y * step + x * pixel_bytes);
    }
  }
  return GrayFromRaw({encoding, kWidth, kHeight, step, false, &data});
}

double Grey(const Result<cv::Mat>& image) {
  EXPECT_TRUE(image);
  EXPECT_EQ(image->size(), cv::Size(kWidth, kHeight));
  EXPECT_EQ(image->type(), CV_8UC1);
  EXPECT_EQ(cv::countNonZero(*image != image->at<uint8_t>(0, 0)), 0);
  return image->at<uint8_t>(0, 0);
}

TEST(RawImage, EveryEncodingBecomesItsLuminance) {
  EXPECT_EQ(Grey(Read("mono8", 1, {50})), 50);
  EXPECT_EQ(Grey(Read("mono16", 2, {200, 50})), 50);
  EXPECT_NEAR(Grey(Read("bgr8", 3, {100, 0, 0})), 11.4, 1);
  EXPECT_NEAR(Grey(Read("rgb8", 3, {100, 0, 0})), 29.9, 1);
  EXPECT_NEAR(Grey(Read("bgra8", 4, {0, 100, 0, 255})), 58.7, 1);
  EXPECT_NEAR(Grey(Read("rgba8", 4, {100, 0, 0, 255})), 29.9, 1);
}

TEST(RawImage, SensorsOfTenAndTwelveBitsAreNotDark) {
  EXPECT_EQ(Grey(Read("mono16", 2, {0x20, 0x03})), 0x320 >> 2);  // 800 of 1023
  EXPECT_EQ(Grey(Read("mono16", 2, {0x00, 0x0C})), 0xC0);        // 3072 of 4095
  EXPECT_EQ(Grey(Read("yuv422", 2, {128, 77})), 77);
  EXPECT_EQ(Grey(Read("yuv422_yuy2", 2, {77, 128})), 77);
}

// Red alone shines; which of each 2 x 2 pixels it is, is the pattern's name.
TEST(RawImage, BayerPatternsAreNotMixedUp) {
  for (const auto& [encoding, red] :
       {std::pair("bayer_rggb8", 0), {"bayer_grbg8", 1}, {"bayer_gbrg8", 2}, {"bayer_bggr8", 3}}) {
    std::vector<uint8_t> data(8 * 8, 0);
    for (size_t i = 0; i < data.size(); ++i) {
      if (static_cast<int>(i / 8 % 2 * 2 + i % 8 % 2) == red) data[i] = 200;
    }
    const auto image = GrayFromRaw({encoding, 8, 8, 8, false, &data});
    ASSERT_TRUE(image) << encoding;
    EXPECT_NEAR(image->at<uint8_t>(4, 4), 0.299 * 200, 2) << encoding;
  }
}

TEST(RawImage, TheUpperByteDependsOnTheOrder) {
  std::vector<uint8_t> data = {50, 200, 50, 200, 50, 200, 50, 200};
  const auto image = GrayFromRaw({"mono16", 2, 2, 4, true, &data});
  ASSERT_TRUE(image);
  EXPECT_EQ(image->at<uint8_t>(1, 1), 50);
}

TEST(RawImage, WhatDoesNotFitIsRefused) {
  const std::vector<uint8_t> data(12);
  const auto refusal = [&](const RawImage& raw) {
    const auto image = GrayFromRaw(raw);
    return image ? std::string() : image.error().message;
  };
  EXPECT_THAT(refusal({"32FC1", 2, 2, 8, false, &data}), HasSubstr("encoding: expected one of"));
  EXPECT_EQ(refusal({"mono8", 4, 4, 4, false, &data}), "expected 16 bytes, got 12");
  EXPECT_EQ(refusal({"bgr8", 2, 2, 4, false, &data}), "expected rows of 6 bytes, got 4");
  EXPECT_EQ(refusal({"mono8", 0, 4, 4, false, &data}), "an image of 0 x 4 px");
  EXPECT_EQ(refusal({"mono8", 4000000000U, 4000000000U, 4000000000U, false, &data}),
            "an image of 4000000000 x 4000000000 px");
  EXPECT_EQ(refusal({"mono8", 4, 60000, 4000000000U, false, &data}),
            "expected 240000000000000 bytes, got 12");
}

}  // namespace
}  // namespace tagtwist::internal::raw_image_test
