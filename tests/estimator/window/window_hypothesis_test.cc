#include "estimator/window/window_hypothesis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "frontend/types/so3.h"
#include "tests/support/exact_model.h"

namespace tagtwist::window_hypothesis_test {
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

// By the graph and by the window's own system alike.
TEST(WindowHypothesis, AContradictedTagIsDroppedUnlessItIsMostOfTheNewestFrame) {
  for (const bool by_steps : {false, true}) {
    const auto solve = by_steps ? StepHypothesis : SolveHypothesis;
    Scene scene;
    std::vector<GraphFrame>& frames = scene.account.input.frames;
    ASSERT_TRUE(solve(scene.setup, scene.noise, {}, &scene.account));
    EXPECT_FALSE(DropContradicted(&scene.account));
    const size_t tags = frames[2].tags.size();
    for (Eigen::Vector2d& corner : frames[2].tags[1].corners) corner.x() += 20;
    const int wrong = frames[2].tags[1].id;
    scene.account.is_step = false;
    ASSERT_TRUE(solve(scene.setup, scene.noise, {}, &scene.account));
    EXPECT_TRUE(DropContradicted(&scene.account));
    ASSERT_EQ(frames[2].tags.size(), tags - 1);
    for (const TagDetection& tag : frames[2].tags) EXPECT_NE(tag.id, wrong);
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
}  // namespace tagtwist::window_hypothesis_test
