#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "frontend/pattern/corner_refiner.h"
#include "tests/support/flights/corner_flight.h"

namespace tagtwist::internal::corner_refiner_views_test {
namespace {

// A frame's tags well inside of the image, with their true corners.
struct View {
  SimulatedFrame frame;
  std::vector<TagDetection> tags;
};

View MakeView(const Setting& setting = {}) {
  View out{MakeFrame(MakeFlightOf(setting), 0.4), {}};
  for (const TagDetection& tag : out.frame.detections) {
    const bool inside = std::all_of(tag.corners.begin(), tag.corners.end(),
                                    [&](const auto& c) { return setting.camera.Contains(c, 12); });
    if (inside) out.tags.push_back(tag);
  }
  EXPECT_GE(out.tags.size(), 5U);
  return out;
}

TEST(CornerRefinerViews, AnotherTagsPatternIsRefused) {
  const View view = MakeView();
  const CornerRefiner refiner = MakeRefiner();
  for (TagDetection tag : view.tags) {
    ASSERT_TRUE(refiner.Refine(view.frame.image, tag)) << tag.id;
    for (int wrong = 1; wrong < 12; ++wrong) {
      TagDetection other = tag;
      other.id = (tag.id + wrong) % 108;
      EXPECT_FALSE(refiner.Refine(view.frame.image, other)) << tag.id << " as " << other.id;
      EXPECT_FALSE(refiner.Refine(view.frame.image, other, 2)) << tag.id << " as " << other.id;
    }
    std::rotate(tag.corners.begin(), tag.corners.begin() + 1, tag.corners.end());
    EXPECT_FALSE(refiner.Refine(view.frame.image, tag)) << tag.id << " turned";
  }
  TagDetection strange = view.tags[0];
  strange.id = 400;
  EXPECT_FALSE(refiner.Refine(view.frame.image, strange)) << "not in the map";
}

TEST(CornerRefinerViews, AStartTwoPixelsOffConverges) {
  const View view = MakeView();
  const CornerRefiner refiner = MakeRefiner();
  const Eigen::Vector2d shifts[] = {{2, 0.3}, {-1.4, 1.4}, {0.2, -2}, {1.5, 2}};
  for (const TagDetection& tag : view.tags) {
    for (const Eigen::Vector2d& shift : shifts) {
      TagDetection start = tag;
      for (size_t c = 0; c < 4; ++c) {
        start.corners[c] += shift + 0.3 * Eigen::Vector2d(c % 2 == 0 ? 1 : -1, c < 2 ? 1 : -1);
      }
      const auto refined = refiner.Refine(view.frame.image, start, 3);
      ASSERT_TRUE(refined) << tag.id << " from " << shift.transpose();
      EXPECT_LT(Difference(refined->corners, tag.corners).norm() / std::sqrt(8), 0.05) << tag.id;
    }
  }
}

// Covers a share of every tag from one side with a grey.
TEST(CornerRefinerViews, PartlyCoveredTagsAreHonestOrRefused) {
  const CornerRefiner refiner = MakeRefiner();
  for (const int grey : {0, 120, 255}) {
    for (const double share : {0.12, 0.25, 0.5, 0.7}) {
      const View view = MakeView();
      double nees = 0;
      int refined_tags = 0;
      for (const TagDetection& tag : view.tags) {
        cv::Mat image = view.frame.image.clone();
        Eigen::Vector2d low = tag.corners[0], high = tag.corners[0];
        for (const auto& corner : tag.corners) {
          low = low.cwiseMin(corner);
          high = high.cwiseMax(corner);
        }
        const int width = static_cast<int>(share * (high.x() - low.x()) + 4);
        const cv::Rect cover(static_cast<int>(low.x()) - 4, static_cast<int>(low.y()) - 6, width,
                             static_cast<int>(high.y() - low.y()) + 12);
        image(cover & cv::Rect(0, 0, image.cols, image.rows)) = grey;
        const auto refined = refiner.Refine(image, tag);
        if (!refined) continue;
        ++refined_tags;
        const auto error = Difference(refined->corners, tag.corners);
        nees += error.dot(refined->covariance.inverse() * error) / 8;
      }
      if (refined_tags > 0) {
        EXPECT_LT(nees / refined_tags, 2.5) << grey << " over " << share;
      }
      if (share > 0.4) {
        EXPECT_EQ(refined_tags, 0) << grey << " over " << share;
      }
    }
  }
}

TEST(CornerRefinerViews, BlankTinyAndCutPatchesAreRefused) {
  const CornerRefiner refiner = MakeRefiner();
  TagDetection tag;
  tag.id = 5;
  tag.corners = {{{100, 140}, {140, 140}, {140, 100}, {100, 100}}};
  for (const int grey : {0, 128, 255}) {
    EXPECT_FALSE(refiner.Refine(cv::Mat(240, 376, CV_8UC1, cv::Scalar(grey)), tag, 2));
  }
  EXPECT_FALSE(refiner.Refine(cv::Mat(), tag));
  EXPECT_FALSE(refiner.Refine(cv::Mat(10, 10, CV_8UC1, cv::Scalar(9)), tag, 3));
  EXPECT_FALSE(refiner.Refine(cv::Mat(240, 376, CV_8UC3, cv::Scalar::all(9)), tag));
  const View view = MakeView();
  for (const Eigen::Vector2d& place :
       {Eigen::Vector2d(-15, -15), {-120, 0}, {240, 60}, {1e9, 0}, {NAN, 0}, {255, 110}}) {
    TagDetection moved = tag;
    for (auto& corner : moved.corners) corner += place;
    EXPECT_FALSE(refiner.Refine(view.frame.image, moved, 2)) << place.transpose();
  }
  for (const double side : {0.0, 1.0, 5.0}) {
    TagDetection tiny = tag;
    tiny.corners = {{{100, 100 + side}, {100 + side, 100 + side}, {100 + side, 100}, {100, 100}}};
    EXPECT_FALSE(refiner.Refine(view.frame.image, tiny, 2)) << side;
  }
}

TEST(CornerRefinerViews, AllTagsKeepTheirPlacesAndGetACovariance) {
  const View view = MakeView();
  std::vector<TagDetection> tags = view.tags;
  tags[1].id = (tags[1].id + 50) % 108;  // will not be believed
  const CornerRefiner refiner = MakeRefiner();
  const auto all = refiner.RefineAll(view.frame.image, tags).tags;
  const auto again = MakeRefiner().RefineAll(view.frame.image, tags).tags;
  ASSERT_EQ(all.size(), tags.size());
  for (size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].id, tags[i].id);
    ASSERT_TRUE(all[i].covariance);
    EXPECT_EQ(all[i].corners, again[i].corners);
    EXPECT_EQ(*all[i].covariance, *again[i].covariance);
  }
  EXPECT_EQ(all[1].corners, tags[1].corners);
  EXPECT_GT((*all[1].covariance)(0, 0), 0.5);
  EXPECT_LT((*all[0].covariance)(0, 0), 0.01);
}

}  // namespace
}  // namespace tagtwist::internal::corner_refiner_views_test
