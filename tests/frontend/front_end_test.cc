#include "frontend/front_end.h"

#include <gtest/gtest.h>

#include <opencv2/core/mat.hpp>

#include "frontend/tags/find_tags.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::front_end_test {
namespace {

TagDetection TagAt(int id, double x, double y, double side = 20) {
  TagDetection tag;
  tag.id = id;
  tag.corners = {Eigen::Vector2d(x, y + side), {x + side, y + side}, {x + side, y}, {x, y}};
  return tag;
}

std::vector<int> Ids(const std::vector<TagDetection>& tags) {
  std::vector<int> ids;
  for (const auto& tag : tags) ids.push_back(tag.id);
  return ids;
}

TEST(FilterTags, DropsStrangersRepeatsAndBrokenCornersAndSorts) {
  const TagMap map = MakeTagMap(TagGrid());
  auto broken = TagAt(12, 50, 50), infinite = TagAt(13, 50, 50);
  broken.corners[2].y() = std::nan("");
  infinite.corners[1].x() = std::numeric_limits<double>::infinity();
  const std::vector<TagDetection> tags = {TagAt(90, 10, 10),  TagAt(108, 40, 10), TagAt(5, 70, 10),
                                          TagAt(5, 200, 100), TagAt(3, 100, 10),  broken,
                                          infinite,           TagAt(5, 250, 100), TagAt(-1, 9, 90)};
  EXPECT_EQ(Ids(FilterTags(tags, map, Camera(), 1.5)), (std::vector<int>{3, 90}));
}

TEST(FilterTags, DropsTagsAtTheBorder) {
  const TagMap map = MakeTagMap(TagGrid());
  const Camera camera;  // pixel centres from 0 to 375 and 0 to 239
  const std::vector<TagDetection> tags = {TagAt(0, 1.4, 50),        TagAt(1, 1.6, 80),
                                          TagAt(2, 375 - 21.4, 50), TagAt(3, 375 - 21.6, 80),
                                          TagAt(4, 50, 1.4),        TagAt(5, 80, 239 - 21.4),
                                          TagAt(6, 50, 239 - 21.6), TagAt(7, -30, 50)};
  EXPECT_EQ(Ids(FilterTags(tags, map, camera, 1.5)), (std::vector<int>{1, 3, 6}));
}

TEST(FrontEnd, TellsAnImageThatIsTheOneBefore) {
  FrontEnd front_end(MakeSetUp(Camera(), CourseCamFromBody(), MakeTagMap(TagGrid())), {});
  cv::Mat image(240, 376, CV_8UC1, cv::Scalar(90));
  EXPECT_TRUE(front_end.Process(0, {}, image).same_image.empty());
  EXPECT_EQ(front_end.Process(1, {}, image.clone()).same_image, std::vector<int>{0});
  image.at<uchar>(239, 375) = 91;  // its buffer is the caller's
  EXPECT_TRUE(front_end.Process(2, {}, image).same_image.empty());
  EXPECT_TRUE(front_end.Process(3, {}, cv::Mat()).same_image.empty());
  EXPECT_TRUE(front_end.Process(4, {}, image).same_image.empty());
}

TEST(FrontEnd, ProcessIsTrackThenSeed) {
  const TagMap map = MakeTagMap(TagGrid());
  const Camera camera;
  FrontEnd whole(MakeSetUp(camera, CourseCamFromBody(), map), {}),
      stages(MakeSetUp(camera, CourseCamFromBody(), map), {});
  for (int i = 0; i < 3; ++i) {
    const Pose world_from_body = Hover({1.4 + 0.02 * i, 1.2, 1.3}, 0.1);
    const auto tags = SeeTags(map, camera, CourseCamFromBody() * Inverse(world_from_body));
    const int64_t t_ns = 20'000'000 * i;
    const FrameMeasurements frame = whole.Process(t_ns, tags, cv::Mat());
    const ClosedForm closed_form = stages.ClosedFormOf(t_ns, tags, stages.Track(tags, cv::Mat()));
    EXPECT_EQ(frame.t_ns, t_ns);
    EXPECT_EQ(Ids(frame.tags), Ids(tags));
    EXPECT_TRUE(frame.tracks.empty());
    ASSERT_TRUE(frame.closed_form.world_from_body);
    EXPECT_EQ(frame.closed_form.world_from_body->params, closed_form.world_from_body->params);
    EXPECT_EQ(frame.closed_form.twist_low_pass.has_value(), i > 0);
    EXPECT_EQ(closed_form.twist_low_pass.has_value(), i > 0);
  }
}

}  // namespace
}  // namespace tagtwist::internal::front_end_test
