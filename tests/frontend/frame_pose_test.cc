#include "frontend/geometry/frame_pose.h"

#include <gtest/gtest.h>

#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::frame_pose_test {
namespace {

const TagMap& Mat() {
  static const TagMap map = MakeTagMap(TagGrid());
  return map;
}

std::vector<TagDetection> Only(const std::vector<TagDetection>& tags, std::vector<int> ids) {
  std::vector<TagDetection> out;
  for (const auto& tag : tags) {
    if (std::find(ids.begin(), ids.end(), tag.id) != ids.end()) out.push_back(tag);
  }
  return out;
}

TEST(FramePose, IsExactWithoutNoiseAndLensDistortionIncluded) {
  Camera camera;
  camera.k1 = -0.15;
  camera.k2 = 0.03;
  camera.p2 = 0.002;
  const Pose world_from_body = Hover({1.6, 1.3, 1.2}, 2.1, {0.2, 0.1, 0});
  const auto tags = SeeTags(Mat(), camera, CourseCamFromBody() * Inverse(world_from_body));
  ASSERT_GE(tags.size(), 4u);
  const FramePose found = FindFramePose(tags, Mat(), camera, CourseCamFromBody());
  ASSERT_EQ(found.status, FramePoseStatus::kOk);
  EXPECT_LT(PositionErrorM(found.world_from_body, world_from_body), 1e-6);
  EXPECT_LT(RotationErrorRad(found.world_from_body, world_from_body), 1e-6);
  EXPECT_EQ(std::count(found.tag_inlier.begin(), found.tag_inlier.end(), true),
            static_cast<long>(tags.size()));
  EXPECT_LT(found.rms_px, 1e-6);
  EXPECT_TRUE(found.alternatives.empty());
}

TEST(FramePose, SurvivesAWrongIdAmongThreeTags) {
  const Camera camera;
  const Pose world_from_body = Hover({1.5, 1.3, 1.3}, 0.4, {0.1, 0.05, 0});
  const Pose cam_from_world = CourseCamFromBody() * Inverse(world_from_body);
  const auto all = SeeTags(Mat(), camera, cam_from_world, 0.2);
  ASSERT_GE(all.size(), 6u);
  for (size_t wrong = 0; wrong < 3; ++wrong) {
    std::vector<TagDetection> tags = {all[0], all[2], all[5]};
    tags[wrong].id = (tags[wrong].id + 40) % 108;
    const FramePose found = FindFramePose(tags, Mat(), camera, CourseCamFromBody());
    ASSERT_EQ(found.status, FramePoseStatus::kOk);
    std::vector<bool> expected(3, true);
    expected[wrong] = false;
    EXPECT_EQ(found.tag_inlier, expected);
    EXPECT_LT(PositionErrorM(found.world_from_body, world_from_body), 0.05);
    EXPECT_LT(RotationErrorRad(found.world_from_body, world_from_body), 0.04);
    EXPECT_LT(found.rms_px, 0.6);
  }
}

// Small tags: the better of a single tag's minima is often the wrong one, so both must be tried.
TEST(FramePose, SurvivesAWrongIdAmongThreeSmallTags) {
  const Camera camera;
  const Pose cam_from_world =
      MakePose(ExpSo3({M_PI, 0, 0}) * ExpSo3({0.4, 0.2, 0}), {-0.6, 0.6, 3.5});
  int n_right = 0;
  constexpr int kRounds = 100;
  for (unsigned round = 1; round <= kRounds; ++round) {
    const auto all = SeeTags(Mat(), camera, cam_from_world, 0.3, round);
    const size_t n = all.size() / 3;
    std::vector<TagDetection> tags = {all[round % n], all[n + 7 * round % n],
                                      all[2 * n + 3 * round % n]};
    const size_t wrong = round % 3;
    tags[wrong].id = (tags[wrong].id + 31 + static_cast<int>(round % 40)) % 108;
    std::vector<bool> expected(3, true);
    expected[wrong] = false;
    n_right += FindFramePose(tags, Mat(), camera, Pose()).tag_inlier == expected ? 1 : 0;
  }
  EXPECT_GE(n_right, kRounds - 1);
}

TEST(FramePose, FindsTheLargestAgreementAmongManyWrongIds) {
  const Camera camera;
  const Pose world_from_body = Hover({1.5, 1.3, 2.2}, 1.0);
  const auto truth = SeeTags(Mat(), camera, CourseCamFromBody() * Inverse(world_from_body), 0.2);
  ASSERT_GE(truth.size(), 15u);
  auto tags = truth;
  std::vector<bool> expected(tags.size(), true);
  for (size_t i = 0; i < tags.size(); i += 3) {
    tags[i].id = (truth[i].id + 17 + 5 * static_cast<int>(i)) % 108;
    expected[i] = false;
  }
  const FramePose found = FindFramePose(tags, Mat(), camera, CourseCamFromBody());
  EXPECT_EQ(found.tag_inlier, expected);
  EXPECT_LT(PositionErrorM(found.world_from_body, world_from_body), 0.02);
}

TEST(FramePose, OneSmallTagKeepsBothMinima) {
  const Camera camera;
  // A small tag, tilted by 16 degrees, and noise: either minimum may come out first.
  const Pose cam_from_world =
      MakePose(ExpSo3({M_PI, 0, 0}) * ExpSo3({0.25, 0.12, 0}), {-0.1, 0.05, 1.6});
  const Pose world_from_cam = Inverse(cam_from_world);
  int n_both = 0, n_truth_kept = 0;
  for (unsigned noise_seed = 1; noise_seed <= 20; ++noise_seed) {
    const auto tags = Only(SeeTags(Mat(), camera, cam_from_world, 0.3, noise_seed), {0});
    ASSERT_EQ(tags.size(), 1u);
    const FramePose found = FindFramePose(tags, Mat(), camera, Pose());
    ASSERT_EQ(found.status, FramePoseStatus::kOk);
    double nearest = RotationErrorRad(found.world_from_body, world_from_cam);
    for (const Pose& other : found.alternatives) {
      nearest = std::min(nearest, RotationErrorRad(other, world_from_cam));
    }
    n_both += found.alternatives.empty() ? 0 : 1;
    n_truth_kept += nearest < 0.25 ? 1 : 0;
  }
  EXPECT_GE(n_both, 14);
  EXPECT_GE(n_truth_kept, 19);
}

TEST(FramePose, TwoDistantTagsKeepBothMinimaToo) {
  const Camera camera;
  const Pose cam_from_world =
      MakePose(ExpSo3({M_PI, 0, 0}) * ExpSo3({0.3, 0.15, 0}), {-0.2, 0.2, 4});
  int n_both = 0;
  for (unsigned noise_seed = 1; noise_seed <= 10; ++noise_seed) {
    const auto tags = Only(SeeTags(Mat(), camera, cam_from_world, 0.3, noise_seed), {13, 14});
    ASSERT_EQ(tags.size(), 2u);
    const FramePose found = FindFramePose(tags, Mat(), camera, Pose());
    EXPECT_EQ(found.tag_inlier, std::vector<bool>(2, true));
    n_both += found.alternatives.empty() ? 0 : 1;
  }
  EXPECT_GE(n_both, 7);
}

TEST(FramePose, LeavesOutATagThatWasMovedByAThirdOfItsSide) {
  const Camera camera;
  const Pose world_from_body = Hover({1.5, 1.3, 1.6}, 0.4);
  auto tags = SeeTags(Mat(), camera, CourseCamFromBody() * Inverse(world_from_body), 0.2);
  ASSERT_GE(tags.size(), 6u);
  for (auto& corner : tags[3].corners) corner += Eigen::Vector2d(7, 7);
  const FramePose found = FindFramePose(tags, Mat(), camera, CourseCamFromBody());
  std::vector<bool> expected(tags.size(), true);
  expected[3] = false;
  EXPECT_EQ(found.tag_inlier, expected);
  EXPECT_LT(found.rms_px, 0.4);
}

TEST(FramePose, ManyTagsAtATiltLeaveNoAlternative) {
  const Camera camera;
  const Pose world_from_body = Hover({1.5, 1.3, 1.2}, 0.4, {0.3, 0, 0});
  const auto tags = SeeTags(Mat(), camera, CourseCamFromBody() * Inverse(world_from_body), 0.3);
  ASSERT_GE(tags.size(), 4u);
  EXPECT_TRUE(FindFramePose(tags, Mat(), camera, CourseCamFromBody()).alternatives.empty());
}

TEST(FramePose, UsesTagsOnSeveralPlanes) {
  const Camera camera;
  const TagMap corner_of_a_room("tag36h11",
                                {{1, MakePose(Eigen::Quaterniond::Identity(), {0.3, 0.3, 0}), 0.2},
                                 {2, MakePose(ExpSo3({M_PI / 2, 0, 0}), {0.3, 0.6, 0.3}), 0.2},
                                 {3, MakePose(ExpSo3({0, 0.8, 0}), {-0.1, 0.3, 0.1}), 0.15}});
  // 1.3 m above the floor, looking down and at the wall.
  const Pose cam_from_world = Inverse(MakePose(ExpSo3({0.65 - M_PI, 0, 0}), {0.15, -0.5, 1.3}));
  const auto tags = SeeTags(corner_of_a_room, camera, cam_from_world);
  ASSERT_EQ(tags.size(), 3u);
  const FramePose found = FindFramePose(tags, corner_of_a_room, camera, Pose());
  EXPECT_EQ(found.tag_inlier, std::vector<bool>(3, true));
  EXPECT_LT(PositionErrorM(found.world_from_body, Inverse(cam_from_world)), 1e-6);
  EXPECT_TRUE(found.alternatives.empty());
}

TEST(FramePose, SaysWhenThereIsNothingToUse) {
  EXPECT_EQ(FindFramePose({}, Mat(), Camera(), Pose()).status, FramePoseStatus::kNoTags);
  TagDetection stranger, collapsed, broken;
  stranger.id = 400;
  stranger.corners.fill({10, 10});
  collapsed.id = 3;
  collapsed.corners.fill({100, 100});
  broken.id = 4;
  broken.corners.fill({std::nan(""), 100});
  for (const TagDetection& tag : {stranger, broken}) {
    const FramePose found = FindFramePose({tag}, Mat(), Camera(), Pose());
    EXPECT_EQ(found.status, FramePoseStatus::kNoTags);
    EXPECT_EQ(found.tag_inlier, std::vector<bool>(1, false));
  }
  EXPECT_EQ(FindFramePose({collapsed}, Mat(), Camera(), Pose()).status, FramePoseStatus::kNoPose);
}

}  // namespace
}  // namespace tagtwist::internal::frame_pose_test
