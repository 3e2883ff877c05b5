#include "frontend/tags/tag_completion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/support/flights/flight_scene.h"

namespace tagtwist::internal::tag_completion_test {
namespace {

constexpr double kBorderPx = 1.5;

// A picture of the mat, and the true corners of the tags that are whole in it.
class TagCompletion : public testing::Test {
 protected:
  TagCompletion() {
    SimulatorOptions options;
    options.corner_noise_px = 0;
    const RenderedFlight flight = MakeRenderedFlight("figure8", map_, options);
    const SimulatedFrame frame = flight.simulator.MakeFrame(0, flight.StampAt(3));
    image_ = frame.image;
    for (const TagDetection& tag : frame.detections) {
      if (std::all_of(tag.corners.begin(), tag.corners.end(),
                      [](const auto& c) { return Camera().Contains(c, kBorderPx); })) {
        truth_.push_back(tag);
      }
    }
    std::sort(truth_.begin(), truth_.end(),
              [](const auto& a, const auto& b) { return a.id < b.id; });
  }

  std::vector<TagDetection> Complete(const TagMap& map,
                                     const std::vector<TagDetection>& detected) const {
    const auto refiner = CornerRefiner::Create(map, Camera());
    return CompleteTags(image_, *refiner, map, Camera(), kBorderPx,
                        refiner->RefineAll(image_, detected));
  }

  const TagMap map_ = MakeTagMap({});
  cv::Mat image_;
  std::vector<TagDetection> truth_;
};

TEST_F(TagCompletion, FindsWhatTheDetectorMissed) {
  ASSERT_GE(truth_.size(), 10u);
  const auto tags = Complete(map_, {truth_[0], truth_[truth_.size() / 2]});
  ASSERT_EQ(tags.size(), truth_.size());
  for (size_t i = 0; i < tags.size(); ++i) {
    EXPECT_EQ(tags[i].id, truth_[i].id);
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_LT((tags[i].corners[c] - truth_[i].corners[c]).norm(), 0.15);
    }
  }
}

TEST_F(TagCompletion, MendsCornersThatWereTooFarOffToBeRefined) {
  std::vector<TagDetection> detected = {truth_[0], truth_[1], truth_[2], truth_[3]};
  detected[1].corners[2] += Eigen::Vector2d(9, -9);
  const auto refiner = CornerRefiner::Create(map_, Camera());
  ASSERT_FALSE(refiner->RefineAll(image_, detected).IsRefined(detected[1].id));
  const auto tags = Complete(map_, detected);
  ASSERT_EQ(tags.size(), truth_.size());
  EXPECT_LT((tags[1].corners[2] - truth_[1].corners[2]).norm(), 0.15);
}

// Two ids exchanged in the map: neither is found at the other's place, and one that was detected
// there stays.
TEST_F(TagCompletion, BelievesTheImageRatherThanTheMap) {
  std::vector<Tag> tags = map_.tags();
  const auto place_of = [&](int id) {
    return std::find_if(tags.begin(), tags.end(), [&](const Tag& tag) { return tag.id == id; });
  };
  const int a = truth_[1].id, b = truth_[6].id;
  std::swap(place_of(a)->world_from_tag, place_of(b)->world_from_tag);
  const TagMap wrong(map_.family(), tags);
  const auto found = Complete(wrong, {truth_[0], truth_[1], truth_[2], truth_[3], truth_[4]});
  ASSERT_EQ(found.size(), truth_.size() - 1);
  EXPECT_EQ(found[1].id, a);
  EXPECT_LT((found[1].corners[0] - truth_[1].corners[0]).norm(), 0.15);
  EXPECT_TRUE(
      std::none_of(found.begin(), found.end(), [&](const auto& tag) { return tag.id == b; }));
}

// A corner that was fitted may have a standard deviation of just 1 px, and is fitted all the same:
// what is known of a tag says its look, not its covariance.
TEST_F(TagCompletion, ATagIsKnownByItsLookAndNotByItsCovariance) {
  const auto refiner = CornerRefiner::Create(map_, Camera());
  RefinedTags refined = refiner->RefineAll(image_, {truth_[0], truth_[1], truth_[2], truth_[3]});
  ASSERT_TRUE(refined.IsRefined(truth_[1].id));
  refined.tags[1].covariance = Eigen::Matrix<double, 8, 8>::Identity();
  const auto tags = CompleteTags(image_, *refiner, map_, Camera(), kBorderPx, refined);
  ASSERT_EQ(tags.size(), truth_.size());
  EXPECT_EQ((*tags[1].covariance)(0, 0), 1) << "as it was given";
}

TEST_F(TagCompletion, NothingComesOfNothing) {
  EXPECT_TRUE(Complete(map_, {}).empty());
  const cv::Mat empty_floor(240, 376, CV_8UC1, cv::Scalar(200));
  image_ = empty_floor;
  EXPECT_EQ(Complete(map_, {truth_[0], truth_[1]}).size(), 2u);
}

}  // namespace
}  // namespace tagtwist::internal::tag_completion_test
