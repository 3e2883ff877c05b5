#include "frontend/geometry/homography.h"

#include <gtest/gtest.h>

#include "frontend/types/tag_planes.h"
#include "tests/support/draws.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::homography_test {
namespace {

const std::vector<Eigen::Vector2d> kSquare = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};

TEST(FitHomography, IsExactForFourPoints) {
  const std::vector<Eigen::Vector2d> seen = {{10, 20}, {110, 25}, {95, 130}, {5, 100}};
  for (const bool normalise : {false, true}) {
    const auto h = FitHomography(kSquare, seen, normalise);
    ASSERT_TRUE(h);
    for (size_t i = 0; i < 4; ++i) {
      EXPECT_LT((Transfer(*h, kSquare[i]) - seen[i]).norm(), 1e-9) << i;
    }
  }
}

TEST(FitHomography, RefusesTooFewRepeatedAndCollinearPoints) {
  const std::vector<Eigen::Vector2d> three(kSquare.begin(), kSquare.begin() + 3);
  EXPECT_FALSE(FitHomography(three, three, true));
  const std::vector<Eigen::Vector2d> line = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}};
  const std::vector<Eigen::Vector2d> one(4, Eigen::Vector2d(1, 1));
  for (const bool normalise : {false, true}) {
    EXPECT_FALSE(FitHomography(line, line, normalise));
    EXPECT_FALSE(FitHomography(one, one, normalise));
  }
  auto bad = kSquare;
  bad[2].x() = std::nan("");
  EXPECT_FALSE(FitHomography(kSquare, bad, true));
}

// Pixel noise on a plane whose coordinates are far from 0 and large: without normalisation the
// columns of the DLT differ by many orders of magnitude.
TEST(FitHomography, NormalisationKeepsTheFitWellConditioned) {
  Eigen::Matrix3d truth;
  truth << 1.1, 0.1, 30, -0.2, 0.9, -20, 1e-5, 2e-5, 1;
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> place(0, 400), noise(-0.3, 0.3);
  double error_px[2] = {0, 0};
  for (int round = 0; round < 20; ++round) {
    std::vector<Eigen::Vector2d> points, seen;
    for (int i = 0; i < 12; ++i) {
      points.push_back(Eigen::Vector2d::Constant(1e4) + DrawVector<2>(place, engine));
      seen.push_back(Transfer(truth, points.back()) + DrawVector<2>(noise, engine));
    }
    for (const bool normalise : {false, true}) {
      const auto h = FitHomography(points, seen, normalise);
      for (size_t i = 0; i < points.size(); ++i) {
        error_px[normalise ? 1 : 0] +=
            h ? (Transfer(*h, points[i]) - Transfer(truth, points[i])).norm() / 240 : 1e3;
      }
    }
  }
  EXPECT_LT(error_px[1], 0.3);
  EXPECT_GT(error_px[0], 2 * error_px[1]);
}

TEST(PoseFromHomography, PutsThePlaneInFrontWhateverTheSign) {
  const Pose cam_from_plane = MakePose(ExpSo3({2.5, 0.3, -0.4}), {0.1, -0.2, 2});
  Eigen::Matrix3d h;
  const Eigen::Matrix3d rotation = cam_from_plane.rotation().toRotationMatrix();
  h << rotation.leftCols<2>(), cam_from_plane.translation();
  for (const double scale : {1.0, -1.0, 0.01, -70.0}) {
    for (const bool seed_scale : {false, true}) {
      const auto pose = PoseFromHomography(scale * h, kSquare, seed_scale);
      ASSERT_TRUE(pose) << scale;
      EXPECT_LT(RotationErrorRad(*pose, cam_from_plane), 1e-7);
      EXPECT_LT(PositionErrorM(*pose, cam_from_plane), 1e-12);
    }
  }
  EXPECT_FALSE(PoseFromHomography(h, {{0, 0}, {0, 1e3}, {0, -1e3}}, false)) << "both sides";
  EXPECT_FALSE(PoseFromHomography(Eigen::Matrix3d::Zero(), kSquare, false));
}

TEST(PoseFromHomography, SeedScaleDividesByTheFirstColumn) {
  Eigen::Matrix3d h;
  h << 1, 0, 0, 0, 1.2, 0, 0, 0, 3;
  EXPECT_NEAR(PoseFromHomography(h, kSquare, true)->translation().z(), 3, 1e-12);
  EXPECT_NEAR(PoseFromHomography(h, kSquare, false)->translation().z(), 3 / 1.1, 1e-12);
}

TEST(PoseFromTags, IsExactOverTheMatAtAnyTilt) {
  const TagMap map = MakeTagMap(TagGrid());
  const Camera camera;
  for (const double tilt : {0.0, 0.2, 0.5}) {
    for (const bool normalise : {false, true}) {
      const Pose world_from_body = Hover({1.5, 1.2, 1.4}, 0.7, {tilt, -0.5 * tilt, 0});
      const Pose world_from_cam = world_from_body * Inverse(CourseCamFromBody());
      const auto tags = SeeTags(map, camera, Inverse(world_from_cam));
      ASSERT_GE(tags.size(), 4u);
      const auto pose = PoseFromTags(tags, map, Pose(), camera, {normalise, false});
      ASSERT_TRUE(pose);
      EXPECT_LT(RotationErrorRad(*pose, world_from_cam), 1e-7) << tilt;
      EXPECT_LT(PositionErrorM(*pose, world_from_cam), 1e-9) << tilt;
    }
  }
}

TEST(PoseFromTags, IsExactForOneTagOnAWallThroughADistortingLens) {
  Camera camera;
  camera.k1 = -0.2;
  camera.k2 = 0.05;
  camera.p1 = 0.001;
  const Tag tag{4, MakePose(ExpSo3({1.2, 0.4, -0.8}), {3, -2, 1}), 0.3};
  const TagMap map("tag36h11", {tag});
  const Pose tag_from_cam = MakePose(ExpSo3({2.8, 0.3, 0.2}), {0.1, 0.2, 0.9});
  const Pose world_from_cam = tag.world_from_tag * tag_from_cam;
  const auto tags = SeeTags(map, camera, Inverse(world_from_cam));
  ASSERT_EQ(tags.size(), 1u);
  const auto pose = PoseFromTags(tags, map, tag.world_from_tag, camera, {});
  ASSERT_TRUE(pose);
  EXPECT_LT(RotationErrorRad(*pose, world_from_cam), 1e-6);
  EXPECT_LT(PositionErrorM(*pose, world_from_cam), 1e-6);
}

TEST(FindTagPlanes, TheMatIsTheWorldsPlaneAndAWallAnother) {
  std::vector<Tag> tags = MakeTagMap(TagGrid()).tags();
  const Pose wall = MakePose(ExpSo3({M_PI / 2, 0, 0}), {0, 2, 1});
  tags.push_back({500, wall, 0.2});
  tags.push_back({501, wall * MakePose(ExpSo3({0, 0, 1}), {1, 0.5, 0.001}), 0.2});
  tags.push_back({502, MakePose(ExpSo3({M_PI, 0, 0}), {1, 1, 0}), 0.2});  // under the mat
  const TagPlanes planes = FindTagPlanes(tags);
  EXPECT_FALSE(CommonPlane(tags));
  ASSERT_EQ(planes.world_from_plane.size(), 3u);
  EXPECT_EQ(planes.world_from_plane[0].params, Pose().params);
  EXPECT_EQ(planes.plane_of_tag.at(107), 0u);
  EXPECT_EQ(planes.plane_of_tag.at(500), 1u);
  EXPECT_EQ(planes.plane_of_tag.at(501), 1u) << "1 mm off the wall";
  EXPECT_EQ(planes.plane_of_tag.at(502), 2u);
  std::vector<TagDetection> seen(3);
  seen[0].id = 3;
  seen[1].id = 500;
  seen[2].id = 501;
  EXPECT_EQ(MainPlane(planes, seen), 1u);
}

TEST(FindTagPlanes, TheOnlyOneIsTheFirstTagsOrTheWorlds) {
  const Pose wall = MakePose(ExpSo3({M_PI / 2, 0, 0}), {0, 2, 1});
  const Tag first{500, wall, 0.2};
  const Tag beside{501, wall * MakePose(ExpSo3({0, 0, 1}), {1, 0.5, 0.001}), 0.2};
  const auto of_wall = CommonPlane({first, beside});
  ASSERT_TRUE(of_wall);
  EXPECT_EQ(of_wall->params, wall.params);
  const auto of_mat = CommonPlane(MakeTagMap(TagGrid()).tags());
  ASSERT_TRUE(of_mat);
  EXPECT_EQ(of_mat->params, Pose().params);
  EXPECT_FALSE(CommonPlane({}));
}

TEST(FindTagPlanes, ABentTagIsOnThePlaneThatItIsBentAbout) {
  std::vector<Tag> tags = MakeTagMap(TagGrid()).tags();
  tags[0].bend_m = 0.003;
  tags[6].bend_m = -0.003;
  const TagPlanes planes = FindTagPlanes(tags);
  ASSERT_EQ(planes.world_from_plane.size(), 1u);
  EXPECT_EQ(planes.world_from_plane[0].params, Pose().params);
}

}  // namespace
}  // namespace tagtwist::internal::homography_test
