// What one tag shows of motion, however open its pose is.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/motion/bank/motion_history.h"
#include "estimator/motion/bank/tags_alone.h"
#include "estimator/solve/noise_learning.h"
#include "frontend/types/so3.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::lone_tag_test {
namespace {

constexpr double kNoisePx = 0.2;
constexpr int kTag = 40;

Pose BodyAt(const Eigen::Vector3d& turned, const Eigen::Vector3d& moved) {
  const Eigen::Vector3d turn = Eigen::Vector3d(0.05, 0.04, 0.3) + turned;
  const Eigen::Vector3d tag = CourseSetup().map.Find(kTag)->world_from_tag.translation();
  return MakePose(ExpSo3(turn), tag + Eigen::Vector3d(0.05, -0.1, 1.1) + moved);
}

std::vector<TagDetection> See(const EstimatorSetup& setup, const Pose& body, double noise_px,
                              unsigned seed, int id = kTag) {
  std::vector<TagDetection> out;
  for (const TagDetection& tag :
       SeeTags(setup.map, setup.camera, setup.cam_from_body * Inverse(body), noise_px, seed)) {
    if (tag.id == id) out.push_back(tag);
  }
  return out;
}

PoseMeasurement Shown(const EstimatorSetup& setup, const Pose& body, double noise_px,
                      unsigned seed) {
  const auto out = MotionShownByLoneTag(setup, kNoisePx, See(setup, body, noise_px, seed), body);
  EXPECT_TRUE(out);
  return out.value_or(PoseMeasurement());
}

TEST(LoneTag, ShowsATurnAsATurnAndAMoveAsAMove) {
  const EstimatorSetup setup = CourseSetup();
  const Pose body = BodyAt({0, 0, 0}, {0, 0, 0});
  const PoseMeasurement before = Shown(setup, body, 0, 1);
  const Eigen::Vector3d turn(0.03, -0.02, 0.05), move(0.03, 0.02, -0.04);
  const Pose turned = MakePose(body.rotation() * ExpSo3(turn), body.translation());
  const PoseMeasurement after_turn = Shown(setup, turned, 0, 1);
  EXPECT_LT((LogSo3(before.world_from_body.rotation().conjugate() *
                    after_turn.world_from_body.rotation()) -
             turn)
                .norm(),
            1e-6);
  const Pose moved = MakePose(body.rotation(), body.translation() + move);
  const PoseMeasurement after_move = Shown(setup, moved, 0, 1);
  EXPECT_LT((after_move.world_from_body.translation() - before.world_from_body.translation() -
             body.rotation().conjugate() * move)
                .norm(),
            1e-6);
}

TEST(LoneTag, ItsCovarianceIsThatOfManyDraws) {
  const EstimatorSetup setup = CourseSetup();
  const Pose body = BodyAt({0, 0, 0}, {0, 0, 0});
  const PoseMeasurement truth = Shown(setup, body, 0, 1);
  double turn_chi2 = 0, move_chi2 = 0;
  constexpr int kDraws = 400;
  int shown_draws = 0;
  for (int i = 0; i < kDraws; ++i) {
    const auto draw = MotionShownByLoneTag(
        setup, kNoisePx, See(setup, body, kNoisePx, static_cast<unsigned>(i + 1)), body);
    if (!draw) continue;  // once in thousands its corners fit by no chance
    ++shown_draws;
    const PoseMeasurement& shown = *draw;
    const Eigen::Vector3d turn = LogSo3(truth.world_from_body.rotation().conjugate() *
                                        shown.world_from_body.rotation()),
                          move = shown.world_from_body.translation() -
                                 truth.world_from_body.translation();
    turn_chi2 += turn.dot(shown.attitude_covariance.llt().solve(turn)) / 3 / kDraws;
    move_chi2 += move.dot(shown.position_covariance.llt().solve(move)) / 3 / kDraws;
  }
  EXPECT_GE(shown_draws, kDraws - 3);
  EXPECT_NEAR(turn_chi2, 1, 0.15);
  EXPECT_NEAR(move_chi2, 1, 0.15);
  // Of what an attitude is known to by itself, some percent.
  const auto alone = PoseOfTags(setup, 0.1 * kNoisePx, See(setup, body, 0, 1), body);
  ASSERT_TRUE(alone);
  EXPECT_LT(truth.attitude_covariance.trace(), 0.05 * 100 * alone->attitude_covariance.trace());
}

TEST(LoneTag, CornersThatDoNotFitShowNothing) {
  const EstimatorSetup setup = CourseSetup();
  const Pose body = BodyAt({0, 0, 0}, {0, 0, 0});
  std::vector<TagDetection> tags = See(setup, body, 0, 1);
  ASSERT_EQ(tags.size(), 1U);
  tags[0].corners[0].x() += 6;
  EXPECT_FALSE(MotionShownByLoneTag(setup, kNoisePx, tags, body));
  EXPECT_FALSE(MotionShownByLoneTag(setup, kNoisePx, {}, body));
}

GraphFrame FrameOf(int k, const Pose& body, std::vector<TagDetection> tags) {
  GraphFrame out;
  out.t_ns = 33'333'333LL * k;
  out.state.world_from_body = body;
  out.tags = std::move(tags);
  return out;
}

// From the fifth frame on; another tag, or several, not at once; and a body that begins to move is
// seen to, though no pose is measured.
TEST(MotionHistory, FollowsALoneTagThatGoesOn) {
  const EstimatorSetup setup = CourseSetup();
  NoiseModel noise = InitialNoise(setup.options);
  noise.corner_sigma_px = kNoisePx;
  MotionHistory history(noise);
  const Pose body = BodyAt({0, 0, 0}, {0, 0, 0});
  int other = -1;
  for (const TagDetection& tag :
       SeeTags(setup.map, setup.camera, setup.cam_from_body * Inverse(body), 0, 1)) {
    if (tag.id != kTag) other = tag.id;
  }
  ASSERT_NE(other, -1);
  const auto add = [&](int k, const Pose& at, int id) {
    history.Add(setup, noise,
                FrameOf(k, at, See(setup, at, kNoisePx, static_cast<unsigned>(k + 1), id)));
  };
  for (int k = 0; k < 4; ++k) add(k, body, kTag);
  EXPECT_FALSE(history.FollowsTag());
  for (int k = 4; k < 40; ++k) add(k, body, kTag);
  EXPECT_TRUE(history.Follows(See(setup, body, 0, 1)));
  const double at_rest = history.FromBothSides({true, true}).back().linear;
  for (int k = 40; k < 50; ++k) {
    const double t = 0.0333 * (k - 39);
    add(k, BodyAt({0, 0, 0}, {0.5 * t * t, 0, 0}), kTag);
  }
  const auto moving = history.FromBothSides({true, true}).back();
  EXPECT_GT(moving.linear, 1e3 * at_rest);
  // What a move shows a turn may have made.
  EXPECT_NEAR(moving.linear / moving.angular, 1.1 * 1.1, 0.6);
  for (int k = 50; k < 54; ++k) add(k, body, other);
  EXPECT_TRUE(history.Follows(See(setup, body, 0, 1)));
  add(54, body, other);
  EXPECT_FALSE(history.Follows(See(setup, body, 0, 1)));
  EXPECT_TRUE(history.Follows(See(setup, body, 0, 1, other)));
}

}  // namespace
}  // namespace tagtwist::internal::lone_tag_test
