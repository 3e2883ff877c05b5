#include "estimator/motion/repeated_images.h"

#include <gtest/gtest.h>

#include <vector>

namespace tagtwist::internal::repeated_images_test {
namespace {

TagDetection TagAt(double u_px, int camera = 0) {
  TagDetection out;
  out.id = 3;
  out.corners = {Eigen::Vector2d(u_px, 50.25), Eigen::Vector2d(u_px + 20.125, 51),
                 Eigen::Vector2d(u_px + 21.3, 30), Eigen::Vector2d(u_px + 1, 29.7)};
  out.camera = camera;
  return out;
}

FrameMeasurements FrameOf(int64_t t_ns, std::vector<TagDetection> tags) {
  FrameMeasurements out;
  out.t_ns = t_ns;
  out.tags = std::move(tags);
  return out;
}

// Tags left in each frame of one camera in which the tag stands at these places.
std::vector<size_t> TagsLeft(const std::vector<double>& u_px, RepeatedImages* repeated) {
  std::vector<size_t> out;
  for (size_t i = 0; i < u_px.size(); ++i) {
    FrameMeasurements frame = FrameOf(static_cast<int64_t>(i) * 1'000'000'000, {TagAt(u_px[i])});
    repeated->TakeOut(&frame);
    out.push_back(frame.tags.size());
  }
  return out;
}

TEST(RepeatedImages, AreNoMeasurementsWhereTheTagsMove) {
  RepeatedImages repeated;
  EXPECT_EQ(TagsLeft({100, 103.3, 103.3, 103.3, 110}, &repeated),
            (std::vector<size_t>{1, 1, 0, 0, 1}));
  EXPECT_EQ(repeated.count(), 2U);
  ASSERT_TRUE(repeated.Warning());
  EXPECT_NE(repeated.Warning()->find("2 frames, first at 2.000 s, repeat the image"),
            std::string::npos)
      << *repeated.Warning();
}

TEST(RepeatedImages, AtRestWithoutNoiseAreAsGoodAsAny) {
  RepeatedImages repeated;
  EXPECT_EQ(TagsLeft({100, 100, 100, 100.01, 100.02, 100.02}, &repeated),
            (std::vector<size_t>(6, 1)));
  EXPECT_FALSE(repeated.Warning());
}

TEST(RepeatedImages, CornersRoundedToFullPixelsStandStillInSlowMotion) {
  const auto seen = [](double u_px) {
    TagDetection tag = TagAt(0);
    for (Eigen::Vector2d& corner : tag.corners) {
      corner = (corner + Eigen::Vector2d(u_px, 0)).array().round();
    }
    return FrameOf(0, {tag});
  };
  RepeatedImages slow, fast;
  for (const double u_px : {100.0, 100.6, 101.0, 101.2, 101.6, 102.0}) {
    FrameMeasurements frame = seen(u_px);
    slow.TakeOut(&frame);
    EXPECT_EQ(frame.tags.size(), 1U) << u_px;
  }
  for (const double u_px : {100.0, 104.0, 104.0}) {
    FrameMeasurements frame = seen(u_px);
    fast.TakeOut(&frame);
  }
  EXPECT_EQ(fast.count(), 1U);
}

TEST(RepeatedImages, OfOneCameraLeaveTheOthers) {
  RepeatedImages repeated;
  for (const double u_px : {100.0, 105.0}) {
    FrameMeasurements frame = FrameOf(0, {TagAt(u_px, 0), TagAt(u_px, 1)});
    frame.cameras = {0, 1};
    repeated.TakeOut(&frame);
  }
  FrameMeasurements frame = FrameOf(0, {TagAt(110, 0), TagAt(105, 1)});
  frame.cameras = {0, 1};
  frame.tracks.resize(2);
  frame.tracks[1].camera = 1;
  repeated.TakeOut(&frame);
  ASSERT_EQ(frame.tags.size(), 1U);
  EXPECT_EQ(frame.tags[0].camera, 0);
  ASSERT_EQ(frame.tracks.size(), 1U);
  EXPECT_EQ(frame.tracks[0].camera, 0);
}

TEST(RepeatedImages, ImagesToldToBeTheSameNeedNotHaveTheSameCorners) {
  RepeatedImages repeated;
  TagsLeft({100, 105}, &repeated);
  FrameMeasurements frame = FrameOf(0, {TagAt(105.0001)});
  frame.same_image = {0};
  frame.closed_form.world_from_body = Pose();
  repeated.TakeOut(&frame);
  EXPECT_TRUE(frame.tags.empty());
  EXPECT_FALSE(frame.closed_form.world_from_body);
}

TEST(RepeatedImages, OfAViewWithoutTagsTellNothing) {
  RepeatedImages repeated;
  TagsLeft({100, 105}, &repeated);
  FrameMeasurements none = FrameOf(0, {}), again = FrameOf(0, {TagAt(105)});
  repeated.TakeOut(&none);
  repeated.TakeOut(&again);
  EXPECT_EQ(again.tags.size(), 1U);
}

}  // namespace
}  // namespace tagtwist::internal::repeated_images_test
