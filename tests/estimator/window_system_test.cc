#include "estimator/solve/window_system.h"

#include <gtest/gtest.h>

#include "estimator/graph/marginalisation.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/start/recording_start.h"
#include "tests/support/exact_model.h"

namespace tagtwist {
namespace {

constexpr size_t kFrames = 12;

struct Case {
  EstimatorSetup setup;
  NoiseModel noise;
  std::vector<GraphFrame> frames;

  explicit Case(WhiteNoiseOn prior) : setup(CourseSetup(GivenNoise(ModelUnder(prior, 3)))) {
    noise = InitialNoise(setup.options);
    frames = *StartFrames(setup, DrawFlight(ModelUnder(prior, 3)).measurements);
    frames.resize(kFrames + 1);
  }
  GraphInput First(size_t n) const {
    GraphInput input;
    input.frames.assign(frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(n));
    return input;
  }
};

void ExpectSame(const Solution& a, const Solution& b) {
  ASSERT_EQ(a.graph.states.size(), b.graph.states.size());
  for (size_t i = 0; i < a.graph.states.size(); ++i) {
    const int k = static_cast<int>(i);
    const StateVector d =
        Difference(ToBodyState(a.graph.states[i]), ToBodyState(b.graph.states[i]));
    const StateCovariance p = BodyCovariance(b.covariance, k);
    // What the quadratic forms neglect is far below what the states are known to.
    EXPECT_LT(d.dot(p.llt().solve(d)), 1e-4) << i;
    EXPECT_LT((BodyCovariance(a.covariance, k) - p).norm(), 1e-3 * p.norm()) << i;
  }
  EXPECT_NEAR(a.cost, b.cost, 1e-4 * b.cost);
}

class WindowSystemTest : public UnderBothPriors {};
INSTANTIATE_UNDER_BOTH_PRIORS(WindowSystemTest);

TEST_P(WindowSystemTest, SolvesAsTheGraphDoes) {
  const Case c(GetParam());
  const auto whole = SolveAndInvert(c.setup, c.noise, c.First(kFrames), {50});
  WindowSystem system;
  const auto stepped = system.Solve(c.setup, c.noise, {20}, c.First(kFrames));
  ASSERT_TRUE(whole && stepped);
  ExpectSame(*stepped, *whole);
}

TEST_P(WindowSystemTest, StopsInTimeAfterOneStep) {
  const Case c(GetParam());
  const auto solve = [&](const SolveOptions& options) {
    WindowSystem system;
    return *system.Solve(c.setup, c.noise, options, c.First(kFrames));
  };
  const Solution one = solve({1}), all = solve({20}),
                 hurried = solve({20, 1e-6, [] { return true; }});
  EXPECT_NE(one.cost, all.cost);
  EXPECT_EQ(hurried.cost, one.cost);
  EXPECT_EQ(hurried.covariance.size(), static_cast<int>(kFrames));
}

TEST_P(WindowSystemTest, FrameByFrameItEndsWhereTheGraphDoes) {
  const Case c(GetParam());
  WindowSystem system;
  GraphInput input;
  for (const GraphFrame& frame : c.frames) {
    if (input.frames.size() == kFrames) break;
    input.frames.push_back(frame);
    const auto stepped = system.Solve(c.setup, c.noise, {4}, input);
    ASSERT_TRUE(stepped);
    TakeStates(stepped->graph, &input.frames);
  }
  const auto stepped = system.Solve(c.setup, c.noise, {4}, input);
  const auto whole = SolveAndInvert(c.setup, c.noise, c.First(kFrames), {50});
  ASSERT_TRUE(whole && stepped);
  ExpectSame(*stepped, *whole);
}

TEST_P(WindowSystemTest, WhatLeavesIsKeptAsTheGraphKeepsIt) {
  const Case c(GetParam());
  WindowSystem system;
  GraphInput input = c.First(kFrames);
  const auto before = system.Solve(c.setup, c.noise, {20}, input);
  auto whole = SolveAndInvert(c.setup, c.noise, input, {50});
  ASSERT_TRUE(before && whole);
  TakeStates(before->graph, &input.frames);
  system.MarginalizeFirst();
  input.frames.erase(input.frames.begin());
  input.frames.push_back(c.frames[kFrames]);
  const auto stepped = system.Solve(c.setup, c.noise, {20}, input);
  GraphInput by_graph = input, by_factor = input;
  by_graph.prior = MarginalizeFirstState(whole->graph);
  WindowSystem again = system;
  by_factor.prior = again.Prior();
  const auto with_graph = SolveAndInvert(c.setup, c.noise, by_graph, {50});
  const auto with_factor = SolveAndInvert(c.setup, c.noise, by_factor, {50});
  ASSERT_TRUE(stepped && with_graph && with_factor);
  for (const auto* other : {&*with_graph, &*with_factor}) {
    for (size_t i = 0; i < kFrames; ++i) {
      const int k = static_cast<int>(i);
      const StateVector d =
          Difference(ToBodyState(stepped->graph.states[i]), ToBodyState(other->graph.states[i]));
      const StateCovariance p = BodyCovariance(other->covariance, k);
      EXPECT_LT(d.dot(p.llt().solve(d)), 1e-3) << i;
      EXPECT_LT((BodyCovariance(stepped->covariance, k) - p).norm(), 1e-2 * p.norm()) << i;
    }
  }
}

TEST(WindowSystem, TracksAndPriorsOnSeveralStatesDoNotFit) {
  const EstimatorSetup setup = CourseSetup();
  GraphInput input;
  input.first_frame = 5;
  EXPECT_TRUE(WindowSystem::Fits(setup, input));
  input.segments = {{1, 4, {{1, 1}, {2, 2}}}, {2, 6, {{1, 1}}}};  // before the window; one view
  EXPECT_TRUE(WindowSystem::Fits(setup, input));
  input.segments.push_back({3, 6, {{1, 1}, {2, 2}}});
  EXPECT_FALSE(WindowSystem::Fits(setup, input));
  input.segments.clear();
  Factor prior;
  prior.blocks = {{BlockRef::Kind::kPose, 0}, {BlockRef::Kind::kPose, 1}};
  input.prior = prior;
  EXPECT_FALSE(WindowSystem::Fits(setup, input));
}

TEST(WindowSystem, ATagThatIsWrongIsTold) {
  Case c(WhiteNoiseOn::kJerk);
  GraphInput input = c.First(kFrames);
  for (Eigen::Vector2d& corner : input.frames[7].tags[2].corners) corner.x() += 20;
  WindowSystem system;
  ASSERT_TRUE(system.Solve(c.setup, c.noise, {20}, input));
  EXPECT_EQ(system.TagsBelow(7, kContradictedWeight), std::vector<int>{2});
  EXPECT_TRUE(system.TagsBelow(6, kContradictedWeight).empty());
}

}  // namespace
}  // namespace tagtwist
