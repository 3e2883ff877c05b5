#include "frontend/flow/image_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

namespace tagtwist::internal::image_noise_test {
namespace {

// Shaded paper with black squares over a part of it.
cv::Mat Sheet(double sigma, int squares) {
  std::mt19937_64 engine(2);
  std::normal_distribution<double> noise(0, 1);
  cv::Mat clean(240, 376, CV_64FC1);
  for (int y = 0; y < clean.rows; ++y) {
    for (int x = 0; x < clean.cols; ++x) clean.at<double>(y, x) = 160 + 0.1 * x - 0.05 * y;
  }
  for (int i = 0; i < squares; ++i) {
    cv::rectangle(clean, {20 + 45 * (i % 8), 20 + 45 * (i / 8), 22, 22}, cv::Scalar(40),
                  cv::FILLED);
  }
  cv::GaussianBlur(clean, clean, {0, 0}, 0.7);
  for (int y = 0; y < clean.rows; ++y) {
    for (int x = 0; x < clean.cols; ++x) clean.at<double>(y, x) += sigma * noise(engine);
  }
  cv::Mat image;
  clean.convertTo(image, CV_8U);
  return image;
}

TEST(ImageNoise, IsThatOfTheImage) {
  for (const double sigma : {1.0, 2.0, 5.0, 12.0}) {
    const double with_rounding = std::sqrt(sigma * sigma + 1.0 / 12);
    EXPECT_NEAR(EstimateNoise(Sheet(sigma, 0)), with_rounding, 0.03 * with_rounding);
    EXPECT_NEAR(EstimateNoise(Sheet(sigma, 40)), with_rounding, 0.25 * with_rounding);
  }
}

TEST(ImageNoise, OfAnImageWithoutAnyAndOfNoImage) {
  EXPECT_LT(EstimateNoise(cv::Mat(100, 100, CV_8UC1, cv::Scalar(90))), 0.1);
  EXPECT_EQ(EstimateNoise(cv::Mat(2, 2, CV_8UC1, cv::Scalar(90))), 0);
  EXPECT_EQ(EstimateNoise(cv::Mat()), 0);
}

}  // namespace
}  // namespace tagtwist::internal::image_noise_test
