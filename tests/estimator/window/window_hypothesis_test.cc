#include "estimator/window/window_hypothesis.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "frontend/types/so3.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::window_hypothesis_test {
namespace {

WindowHypothesis Account(double settled_cost, double cost, double turn_rad) {
  WindowHypothesis out;
  out.settled_cost = settled_cost;
  out.solution.cost = cost;
  out.solution.covariance = BlockBandedMatrix(1, 0);
  out.solution.covariance.At(0, 0).diagonal().setConstant(1e-4);
  GraphFrame frame;
  frame.state.world_from_body = MakePose(ExpSo3({turn_rad, 0, 0}), {0, 0, 1});
  out.input.frames = {frame};
  return out;
}

TEST(WindowHypothesis, DoubtIsTheProbabilityOfTheSecond) {
  std::vector<WindowHypothesis> accounts = {Account(1, 2, 0)};
  EXPECT_EQ(DoubtOf(accounts), 0);
  accounts.push_back(Account(2, 1.5, 1));  // costs half of one more
  EXPECT_NEAR(DoubtOf(accounts), std::exp(-0.5) / (1 + std::exp(-0.5)), 1e-15);
  accounts.push_back(Account(9, 9, 2));
  EXPECT_NEAR(DoubtOf(accounts), std::exp(-0.5) / (1 + std::exp(-0.5)), 1e-15);
}

TEST(WindowHypothesis, PruningPutsTheLikeliestFirstAndLeavesOutWhatIsDecided) {
  std::vector<WindowHypothesis> accounts = {Account(0, 12.1, 2), Account(0, 11.9, 1),
                                            Account(2, 1, 0)};
  Prune(&accounts);
  ASSERT_EQ(accounts.size(), 2U);
  EXPECT_DOUBLE_EQ(accounts[0].Cost(), 3);
  EXPECT_DOUBLE_EQ(accounts[1].Cost(), 11.9);
}

TEST(WindowHypothesis, PruningLeavesOneOfTwoThatTellTheSame) {
  std::vector<WindowHypothesis> accounts = {Account(0, 2, 1e-6), Account(0, 1, 0)};
  Prune(&accounts);
  ASSERT_EQ(accounts.size(), 1U);
  EXPECT_DOUBLE_EQ(accounts[0].Cost(), 1);
}

struct Scene {
  EstimatorSetup setup = CourseSetup();
  NoiseModel noise;
  WindowHypothesis account;

  Scene() {
    ExactModelOptions model;
    model.frames = 6;
    noise.corner_sigma_px = model.corner_sigma_px;
    noise.linear = model.linear;
    noise.angular = model.angular;
    const ExactModelFlight flight = DrawFlight(model);
    for (size_t k = 0; k < flight.truth.size(); ++k) {
      GraphFrame frame;
      frame.t_ns = flight.measurements[k].t_ns;
      frame.state = flight.truth[k];
      frame.tags = flight.measurements[k].tags;
      account.input.frames.push_back(frame);
    }
  }
};

// To a hundredth of the standard deviations; by steps some thousandths are neglected.
void ExpectSame(const WindowHypothesis& a, const WindowHypothesis& b) {
  ASSERT_EQ(a.input.frames.size(), b.input.frames.size());
  for (size_t i = 0; i < a.input.frames.size(); ++i) {
    const int k = static_cast<int>(i);
    const StateCovariance p = BodyCovariance(b.solution.covariance, k);
    const StateVector d = Difference(a.input.frames[i].state, b.input.frames[i].state);
    EXPECT_LT(std::sqrt(d.dot(p.llt().solve(d))), 1e-2) << i;
    EXPECT_LT((BodyCovariance(a.solution.covariance, k) - p).norm(), 1e-2 * p.norm()) << i;
  }
}

// By the graph and by the chain alike.
TEST(WindowHypothesis, AContradictedTagIsDroppedUnlessItIsMostOfTheNewestFrame) {
  for (const bool by_steps : {false, true}) {
    const auto solve = by_steps ? StepHypothesis : SolveHypothesis;
    Scene scene;
    std::vector<GraphFrame>& frames = scene.account.input.frames;
    ASSERT_TRUE(solve(scene.setup, scene.noise, {}, &scene.account));
    EXPECT_FALSE(DropContradicted(scene.setup, scene.noise, &scene.account));
    const size_t tags = frames[2].tags.size();
    for (Eigen::Vector2d& corner : frames[2].tags[1].corners) corner.x() += 20;
    const int wrong = frames[2].tags[1].id;
    scene.account.is_step = false;
    ASSERT_TRUE(solve(scene.setup, scene.noise, {}, &scene.account));
    EXPECT_TRUE(DropContradicted(scene.setup, scene.noise, &scene.account));
    ASSERT_EQ(frames[2].tags.size(), tags - 1);
    for (const TagDetection& tag : frames[2].tags) EXPECT_NE(tag.id, wrong);
    // The next solve is one without it.
    ASSERT_TRUE(solve(scene.setup, scene.noise, {}, &scene.account));
    EXPECT_FALSE(DropContradicted(scene.setup, scene.noise, &scene.account));
    WindowHypothesis anew;
    anew.input = scene.account.input;
    ASSERT_TRUE(SolveHypothesis(scene.setup, scene.noise, {}, &anew));
    EXPECT_NEAR(scene.account.solution.cost, anew.solution.cost, 1e-4 * anew.solution.cost);
    ExpectSame(scene.account, anew);
  }
}

// A state that starts where none of its tags can be seen, under the mat, comes back by its motion;
// then they count.
TEST(WindowHypothesis, TagsThatCannotBeEvaluatedAtTheStartComeBack) {
  Scene right;
  ASSERT_TRUE(SolveHypothesis(right.setup, right.noise, {}, &right.account));
  for (const bool by_steps : {false, true}) {
    const auto solve = by_steps ? StepHypothesis : SolveHypothesis;
    Scene scene;
    Pose& pose = scene.account.input.frames[2].state.world_from_body;
    pose = MakePose(pose.rotation(), {0, 0, -1});
    for (int i = 0; i < 2; ++i) {
      ASSERT_TRUE(solve(scene.setup, scene.noise, {}, &scene.account));
    }
    ExpectSame(scene.account, right.account);
  }
}

// Tags that are in the window already are under the noise of the present solve, too.
TEST(WindowHypothesis, AllTagsFollowTheNoise) {
  Scene scene, anew;
  ASSERT_TRUE(StepHypothesis(scene.setup, scene.noise, {}, &scene.account));
  for (const double factor : {2.0, 0.8}) {
    scene.noise.corner_sigma_px = anew.noise.corner_sigma_px =
        factor * ExactModelOptions().corner_sigma_px;
    ASSERT_TRUE(StepHypothesis(scene.setup, scene.noise, {}, &scene.account));
    ASSERT_TRUE(SolveHypothesis(anew.setup, anew.noise, {}, &anew.account));
    ExpectSame(scene.account, anew.account);
  }
}

TEST(WindowHypothesis, WhatLeavesLivesOnInThePrior) {
  for (const bool by_steps : {false, true}) {
    const auto solve = by_steps ? StepHypothesis : SolveHypothesis;
    Scene scene;
    ASSERT_TRUE(solve(scene.setup, scene.noise, {}, &scene.account));
    const BodyState before = scene.account.input.frames.back().state;
    MarginalizeOldest(&scene.account);
    ASSERT_EQ(scene.account.input.frames.size(), 5U);
    EXPECT_EQ(scene.account.input.first_frame, 1);
    ASSERT_TRUE(solve(scene.setup, scene.noise, {}, &scene.account));
    const BodyState& after = scene.account.input.frames.back().state;
    EXPECT_LT((after.world_from_body.translation() - before.world_from_body.translation()).norm(),
              1e-6);
    EXPECT_LT((after.twist.v_world - before.twist.v_world).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace tagtwist::internal::window_hypothesis_test
