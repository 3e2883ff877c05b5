#include "frontend/tags/tag_detector.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "frontend/types/tag_family.h"

namespace tagtwist::internal::tag_detector_test {
namespace {

TagDetector MakeDetector(const std::string& family = "tag36h11") {
  auto detector = TagDetector::Create(family, TagDetectorOptions());
  EXPECT_TRUE(detector);
  return std::move(*detector);
}

// Draws a tag so that its square covers the pixels [x, x + side - 1] x [y, y + side - 1].
void Draw(const std::string& family, int id, int x, int y, int cell_px, cv::Mat* image) {
  const auto patterns = MakeTagPatterns(family, {id});
  ASSERT_TRUE(patterns);
  const TagPattern& pattern = patterns->front();
  const int offset = pattern.outer_cells * cell_px;
  for (int row = 0; row < pattern.cells; ++row) {
    for (int column = 0; column < pattern.cells; ++column) {
      const cv::Rect cell(x - offset + column * cell_px, y - offset + row * cell_px, cell_px,
                          cell_px);
      (*image)(cell) = pattern.IsWhite(column, row) ? 255 : 0;
    }
  }
}

TEST(TagDetector, CornerOrderAndPixelConventionMatchARenderedTag) {
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(255));
  Draw("tag36h11", 5, 120, 80, 20, &image);
  const auto detections = MakeDetector().Detect(image);
  ASSERT_EQ(detections.size(), 1u);
  EXPECT_EQ(detections[0].id, 5);

  // The border's outer edge lies half a pixel outside its outermost pixel centres.
  const double left = 120 - 0.5, right = 279 + 0.5, top = 80 - 0.5, bottom = 239 + 0.5;
  const Eigen::Vector2d expected[] = {{left, bottom}, {right, bottom}, {right, top}, {left, top}};
  Eigen::Vector2d mean_error = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_LT((detections[0].corners[i] - expected[i]).norm(), 0.5) << "corner " << i;
    mean_error += (detections[0].corners[i] - expected[i]) / 4;
  }
  EXPECT_LT(mean_error.norm(), 0.2) << "a systematic offset: pixel-centre convention";
}

TEST(TagDetector, CornerOrderTurnsWithTheTag) {
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(255)), turned;
  Draw("tag36h11", 5, 120, 80, 20, &image);
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
  const auto upright = MakeDetector().Detect(image), quarter = MakeDetector().Detect(turned);
  ASSERT_EQ(upright.size(), 1u);
  ASSERT_EQ(quarter.size(), 1u);
  for (size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d& corner = upright[0].corners[i];
    const Eigen::Vector2d expected(image.rows - 1 - corner.y(), corner.x());
    EXPECT_LT((quarter[0].corners[i] - expected).norm(), 0.6) << "corner " << i;
  }
}

TEST(TagDetector, SeesSmallTagsRepeatedOnesTooSortedById) {
  cv::Mat image(240, 376, CV_8UC1, cv::Scalar(200));
  Draw("tag36h11", 90, 40, 30, 3, &image);
  Draw("tag36h11", 7, 140, 30, 3, &image);
  Draw("tag36h11", 7, 40, 130, 4, &image);
  Draw("tag36h11", 300, 250, 120, 3, &image);
  cv::GaussianBlur(image, image, {0, 0}, 0.7);
  const TagDetector detector = MakeDetector();
  const auto tags = detector.Detect(image);
  ASSERT_EQ(tags.size(), 4u);
  EXPECT_EQ(tags[0].id, 7);
  EXPECT_EQ(tags[1].id, 7);
  EXPECT_LT(tags[0].corners[0].x(), tags[1].corners[0].x());
  EXPECT_EQ(tags[2].id, 90);
  EXPECT_EQ(tags[3].id, 300);
  const auto again = detector.Detect(image), other = MakeDetector().Detect(image);
  for (size_t i = 0; i < 4; ++i) {
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_EQ(again[i].corners[c], tags[i].corners[c]);
      EXPECT_EQ(other[i].corners[c], tags[i].corners[c]);
    }
  }
}

TEST(TagDetector, KnowsOtherFamiliesAndRefusesUnknownOnes) {
  for (const char* family : {"tag25h9", "tag16h5", "tagStandard41h12"}) {
    cv::Mat image(480, 640, CV_8UC1, cv::Scalar(255));
    Draw(family, 3, 200, 160, 20, &image);
    const auto tags = MakeDetector(family).Detect(image);
    ASSERT_EQ(tags.size(), 1u) << family;
    EXPECT_EQ(tags[0].id, 3) << family;
    EXPECT_LT((tags[0].corners[3] - Eigen::Vector2d(199.5, 159.5)).norm(), 1) << family;
  }
  const auto unknown = TagDetector::Create("tag99", TagDetectorOptions());
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("tag99"), std::string::npos);
  TagDetectorOptions options;
  options.max_hamming = 3;
  const auto refused = TagDetector::Create("tag36h11", options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(TagDetectorOptions().Problem(), std::nullopt);
  EXPECT_EQ(refused.error().message, "max_hamming: expected in [0, 2], got 3");
}

TEST(TagDetectorOptions, RefusesWhatTheLibraryScalesWrongly) {
  TagDetectorOptions options;
  for (const double good : {1.0, 1.5, 2.0, 3.0}) {
    options.decimate = good;
    EXPECT_FALSE(options.Problem()) << good;
  }
  for (const double bad : {0.5, 2.5, std::nan("")}) {
    options.decimate = bad;
    EXPECT_NE(options.Problem().value_or("").find("decimate: expected"), std::string::npos) << bad;
  }
}

// Any way to the quads leads to the same corners.
TEST(TagDetector, UpscaleAndDecimateKeepThePixelConvention) {
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(255));
  Draw("tag36h11", 5, 120, 80, 10, &image);
  cv::GaussianBlur(image, image, {0, 0}, 0.8);
  for (const int upscale : {1, 2, 3}) {
    for (const double decimate : {1.0, 1.5, 2.0}) {
      TagDetectorOptions options;
      options.upscale = upscale;
      options.decimate = decimate;
      const auto tags = TagDetector::Create("tag36h11", options)->Detect(image);
      ASSERT_EQ(tags.size(), 1u) << upscale << " " << decimate;
      Eigen::Vector2d centre = Eigen::Vector2d::Zero();
      for (const auto& corner : tags[0].corners) centre += corner / 4;
      EXPECT_LT((centre - Eigen::Vector2d(159.5, 119.5)).norm(), 0.25)
          << upscale << " " << decimate;
    }
  }
}

TEST(TagDetector, FindsNothingInBlankTinyEmptyOrColourImages) {
  const TagDetector detector = MakeDetector();
  EXPECT_TRUE(detector.Detect(cv::Mat(480, 640, CV_8UC1, cv::Scalar(255))).empty());
  EXPECT_TRUE(detector.Detect(cv::Mat()).empty());
  EXPECT_TRUE(detector.Detect(cv::Mat(240, 376, CV_8UC3, cv::Scalar::all(255))).empty());
  for (const int side : {1, 3, 15, 16, 17, 33}) {
    EXPECT_TRUE(detector.Detect(cv::Mat(side, 40, CV_8UC1, cv::Scalar(255))).empty());
    EXPECT_TRUE(detector.Detect(cv::Mat(40, side, CV_8UC1, cv::Scalar(0))).empty());
  }
}

// A part of a larger image has rows that do not follow each other in memory.
TEST(TagDetector, ReadsPartsOfImages) {
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(255));
  Draw("tag36h11", 5, 120, 80, 10, &image);
  const TagDetector detector = MakeDetector();
  const auto whole = detector.Detect(image),
             part = detector.Detect(image(cv::Rect(60, 40, 240, 200)));
  ASSERT_EQ(whole.size(), 1u);
  ASSERT_EQ(part.size(), 1u);
  for (size_t c = 0; c < 4; ++c) {
    EXPECT_LT((part[0].corners[c] + Eigen::Vector2d(60, 40) - whole[0].corners[c]).norm(), 0.3);
  }
}

}  // namespace
}  // namespace tagtwist::internal::tag_detector_test
