// A lens by a sheet that nobody measured.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "estimator/calibration/lens/layout_from_nothing.h"
#include "estimator/calibration/lens/lens_from_nothing.h"
#include "tests/estimator/calibration/drawn_views.h"

namespace tagtwist::internal::layout_test {
namespace {

using namespace drawn_views;
using ::testing::HasSubstr;

class LensAndLayout : public testing::TestWithParam<Case> {};

TEST_P(LensAndLayout, SlowIsTheTruthWithinItsSigmas) {
  const Camera truth = TruthOf(GetParam());
  std::pair<int, int> outside{0, 0};
  for (const unsigned seed : {3U, 4U}) {
    Draw draw;
    draw.seed = seed;
    const auto frames = DrawFrames(truth, Sheet(), draw);
    const auto layout = LayoutFromNothing(frames, {640, 480, "tag36h11", 0.1});
    ASSERT_TRUE(layout) << layout.error().message;
    EXPECT_EQ(layout->tags().size(), 36U);
    auto starts = StartLens(frames, *layout, 640, 480);
    ASSERT_TRUE(starts) << starts.error().message;
    starts->map_is_learned = true;
    const auto found = FindLens(frames, *layout, *starts);
    ASSERT_TRUE(found) << found.error().message;
    ExpectGood(*found, truth, &outside);
  }
  EXPECT_GE(outside.second, 8);
  EXPECT_LE(outside.first, 1) << "of " << outside.second;
}
INSTANTIATE_TEST_SUITE_P(Lenses, LensAndLayout,
                         testing::Values(Case{"pinhole", 690, LensModel::kRadialTangential, 0, 0}),
                         [](const auto& of) { return std::string(of.param.name); });
INSTANTIATE_TEST_SUITE_P(
    SlowLenses, LensAndLayout,
    testing::Values(Case{"barrel", 330, LensModel::kRadialTangential, -0.25, 0.06},
                    Case{"fisheye", 230, LensModel::kEquidistant, 0.02, -0.01}),
    [](const auto& of) { return std::string(of.param.name); });

// Neither sizes nor places are made up where the frames contradict them.
TEST(LayoutFromNothing, TagsOfTwoSizesOrSeenAloneAreRefused) {
  const Camera camera = CameraOf(690, LensModel::kRadialTangential);
  std::vector<Tag> tags = Sheet().tags();
  tags[14].size_m *= 1.2;
  const auto frames = DrawFrames(camera, TagMap("tag36h11", tags), {});
  const auto sizes = LayoutFromNothing(frames, {640, 480, "tag36h11", 0.1});
  ASSERT_FALSE(sizes);
  EXPECT_THAT(sizes.error().message, HasSubstr("are not of one size on one plane"));
  const auto alone = LayoutFromNothing(DrawFrames(camera, TagMap("tag36h11", {tags[14]}), {}),
                                       {640, 480, "tag36h11", 0.1});
  ASSERT_FALSE(alone);
  EXPECT_EQ(alone.error().message, "no two tags are seen together often enough");
  const auto none = LayoutFromNothing({}, {640, 480, "tag36h11", 0.1});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().message, "no frame shows a tag");
}

}  // namespace
}  // namespace tagtwist::internal::layout_test
