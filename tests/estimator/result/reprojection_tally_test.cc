#include "estimator/result/reprojection_tally.h"

#include <gtest/gtest.h>

#include "frontend/types/so3.h"

namespace tagtwist::internal::reprojection_tally_test {
namespace {

constexpr int64_t kSecond = 1'000'000'000;

// A camera over a tag, in the middle of its image, upright.
struct Scene {
  Camera camera;
  TagMap map{"tag36h11", {{7, MakePose(Eigen::Quaterniond::Identity(), {0, 0, 0}), 0.2}}};
  Pose cam_from_world = MakePose(ExpSo3({M_PI, 0, 0}), {0, 0, 1});

  TagDetection SeenOffBy(const Eigen::Vector2d& error_px) const {
    TagDetection out;
    out.id = 7;
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_TRUE(camera.Project(cam_from_world * map.CornersInWorld(7)[c], &out.corners[c]));
      out.corners[c] += error_px;
    }
    return out;
  }
};

TEST(ReprojectionTally, AShiftedTagIsToldInPixelsAndInMetres) {
  const Scene scene;
  ReprojectionTally tally;
  const TagDetection tag = scene.SeenOffBy({0.3, -0.4});
  for (int second = 0; second < 3; ++second) {
    tally.Add(scene.camera, scene.map, second * kSecond, scene.cam_from_world, {tag});
  }
  const ReprojectionErrorsByPlace errors = tally.Errors();
  EXPECT_EQ(errors.squares.blocks(), 3U);
  EXPECT_NEAR(errors.squares.ratio(), 0.25, 1e-9);
  EXPECT_NEAR(errors.rings[0].u.ratio(), 0.3, 1e-9);
  EXPECT_NEAR(errors.rings[0].v.ratio(), -0.4, 1e-9);
  EXPECT_EQ(errors.rings[3].u.blocks(), 0U);
  const TagErrors& of_tag = errors.tags.at(7);
  EXPECT_NEAR(of_tag.px_per_m.ratio(), std::sqrt(scene.camera.fx * scene.camera.fy), 1e-6);
  EXPECT_NEAR(of_tag.x_m.ratio(), 0.3 / scene.camera.fx, 1e-9);
  EXPECT_NEAR(of_tag.y_m.ratio(), 0.4 / scene.camera.fy, 1e-9);  // y points up the image
}

TEST(ReprojectionTally, EachCornerCountsInTheCellWhereItIsSeen) {
  const Scene scene;
  ReprojectionTally tally;
  const TagDetection tag = scene.SeenOffBy({0, 0});
  tally.Add(scene.camera, scene.map, 0, scene.cam_from_world, {tag});
  const ReprojectionErrorsByPlace errors = tally.Errors();
  double weight = 0;
  for (const RegionErrors& cell : errors.cells) weight += cell.squares.weight();
  EXPECT_EQ(weight, 4);
  constexpr int kColumns = ReprojectionErrorsByPlace::kColumns;
  for (const Eigen::Vector2d& corner : tag.corners) {
    const int column = static_cast<int>((corner.x() + 0.5) / scene.camera.width * kColumns);
    const int row = static_cast<int>((corner.y() + 0.5) / scene.camera.height *
                                     ReprojectionErrorsByPlace::kRows);
    EXPECT_GE(errors.cells[static_cast<size_t>(row * kColumns + column)].squares.weight(), 1);
  }
}

TEST(ReprojectionTally, SightingsAreIntervalsThatShortGapsDoNotEnd) {
  const Scene scene;
  ReprojectionTally tally;
  for (const int64_t t_ms : {0, 100, 300, 600, 900}) {
    tally.Add(scene.camera, scene.map, t_ms * 1'000'000, scene.cam_from_world,
              {scene.SeenOffBy({0, 0})});
  }
  const auto seen = tally.Errors().tags.at(7).seen;
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_EQ(seen[0].first_ns, 0);
  EXPECT_EQ(seen[0].last_ns, 300'000'000);
  EXPECT_EQ(seen[1].first_ns, 600'000'000);
  EXPECT_EQ(seen[2].last_ns, 900'000'000);
}

// A tag that flickers for ever: memory stays bounded, nothing that was seen is outside.
TEST(ReprojectionTally, ManyIntervalsAreBridged) {
  const Scene scene;
  const TagDetection tag = scene.SeenOffBy({0, 0});
  ReprojectionTally tally;
  constexpr int kSightings = 3000;
  for (int i = 0; i < kSightings; ++i) {
    tally.Add(scene.camera, scene.map, i * kSecond, scene.cam_from_world, {tag});
  }
  const TagErrors of_tag = tally.Errors().tags.at(7);
  EXPECT_LE(of_tag.seen.size(), 512U);
  EXPECT_EQ(of_tag.seen.front().first_ns, 0);
  EXPECT_EQ(of_tag.seen.back().last_ns, (kSightings - 1) * kSecond);
}

}  // namespace
}  // namespace tagtwist::internal::reprojection_tally_test
