#include "estimator/graph/trajectory.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>

#include "estimator/batch/batch.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/smoother.h"
#include "estimator/start/recording_start.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::trajectory_test {
namespace {

EstimatorSetup SetupFor(const ExactModelOptions& model) { return CourseSetup(GivenNoise(model)); }

class TrajectoryTest : public UnderBothPriors {};
INSTANTIATE_UNDER_BOTH_PRIORS(TrajectoryTest);

// The last state's estimate when every frame has a state in the graph, tags or not.
StateAndCovariance SolvedInGraph(const ExactModelOptions& model,
                                 const std::vector<FrameMeasurements>& measurements, int index) {
  const EstimatorSetup setup = SetupFor(model);
  GraphInput input;
  input.frames = *StartFrames(setup, measurements);
  const auto solution = SolveAndInvert(setup, InitialNoise(setup.options), input, {50});
  EXPECT_TRUE(solution);
  return {ToBodyState(solution->graph.states[static_cast<size_t>(index)]),
          BodyCovariance(solution->covariance, index)};
}

// A frame without tags adds no information: its smoothed state is what the trajectory of the other
// frames says at its time.
TEST_P(TrajectoryTest, BetweenStatesItEqualsAStateWithoutMeasurements) {
  ExactModelOptions model = Model();
  model.frames = 12;
  model.rate_hz = 10;
  model.linear.psd = model.angular.psd = 0.5;
  model.random_seed = 3;
  const ExactModelFlight flight = DrawFlight(model);
  const auto plain = RunBatch(CourseSetUp(), GivenNoise(model), flight.measurements);
  ASSERT_TRUE(plain) << plain.error().message;

  for (const int64_t offset_ns : {10'000'000, 50'000'000, 93'000'000}) {
    std::vector<FrameMeasurements> more = flight.measurements;
    FrameMeasurements extra;
    extra.t_ns = more[5].t_ns + offset_ns;
    more.insert(more.begin() + 6, extra);
    const StateAndCovariance expected = SolvedInGraph(model, more, 6);
    const auto asked = plain->trajectory.At(extra.t_ns);
    ASSERT_TRUE(asked);
    // Exact but for terms of second order in the rotation between the states.
    const StateVector d = Difference(asked->state, expected.state);
    EXPECT_LT(d.dot(expected.covariance.llt().solve(d)), 1e-4) << offset_ns;
    EXPECT_LT((asked->covariance - expected.covariance).norm(), 1e-2 * expected.covariance.norm())
        << offset_ns;
    // Batch says the same of that frame.
    const auto dense = RunBatch(CourseSetUp(), GivenNoise(model), more);
    ASSERT_TRUE(dense) << dense.error().message;
    EXPECT_EQ(dense->frames[6].status, FrameStatus::kPredicted);
    EXPECT_LT(Difference(asked->state, dense->frames[6].state).norm(), 1e-9);
  }
}

TEST_P(TrajectoryTest, AtAStateItIsThatState) {
  ExactModelOptions model = Model();
  model.frames = 6;
  const ExactModelFlight flight = DrawFlight(model);
  const auto result = RunBatch(CourseSetUp(), GivenNoise(model), flight.measurements);
  ASSERT_TRUE(result);
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    const auto asked = result->trajectory.At(flight.measurements[i].t_ns);
    ASSERT_TRUE(asked);
    EXPECT_LT(Difference(asked->state, result->frames[i].state).norm(), 1e-9);
    EXPECT_LT((asked->covariance - result->frames[i].covariance).norm(), 1e-9);
  }
}

TEST_P(TrajectoryTest, BeyondItsEndsThePriorCarriesItOn) {
  ExactModelOptions model = Model();
  model.frames = 8;
  model.rate_hz = 10;
  const ExactModelFlight flight = DrawFlight(model);
  std::vector<FrameMeasurements> more = flight.measurements;
  FrameMeasurements late;
  late.t_ns = more.back().t_ns + 300'000'000;
  more.push_back(late);
  const auto result = RunBatch(CourseSetUp(), GivenNoise(model), flight.measurements);
  ASSERT_TRUE(result);
  const StateAndCovariance expected = SolvedInGraph(model, more, 8);
  const auto after = result->trajectory.At(late.t_ns);
  const StateVector d = Difference(after->state, expected.state);
  EXPECT_LT(d.norm(), 1e-5);
  EXPECT_LT((after->covariance - expected.covariance).norm(), 1e-2 * expected.covariance.norm());
  const auto before = result->trajectory.At(flight.measurements.front().t_ns - 300'000'000);
  EXPECT_GT(before->covariance.trace(), result->frames.front().covariance.trace());
  EXPECT_EQ(before->covariance.llt().info(), Eigen::Success);
  EXPECT_FALSE(Trajectory{}.At(0));
}

// Two states, each known well, with a gap between: just before its end the state before the gap
// says next to nothing, so that it is what the state after it says, carried back.
TEST_P(TrajectoryTest, AtTheEndOfALongGapItIsWhatComesAfterSays) {
  const ExactModelOptions model = Model();
  Trajectory alone;
  alone.linear = model.linear;
  alone.angular = model.angular;
  GraphState second;
  second.t_ns = 5'000'000'000'000;
  second.rates << 0.3, -0.2, 0.1, 0.2, 0.1, -0.3, 0.1, 0.2, -0.1, 0.05, -0.02, 0.1;
  alone.states = {second};
  alone.covariances = {1e-6 * Block::Identity()};
  for (const int64_t gap_s : {30, 300, 3000}) {
    Trajectory both = alone;
    GraphState first = second;
    first.t_ns -= gap_s * 1'000'000'000;
    both.states.insert(both.states.begin(), first);
    both.covariances.push_back(alone.covariances[0]);
    both.cross_covariances = {Block::Zero()};
    for (const int64_t before_ns : {1'000'000, 20'000'000, 60'000'000}) {
      SCOPED_TRACE(std::to_string(gap_s) + " s, " + std::to_string(before_ns) + " ns");
      const auto expected = alone.At(second.t_ns - before_ns);
      const auto asked = both.At(second.t_ns - before_ns);
      ASSERT_TRUE(expected && asked);
      const StateVector sigmas = expected->covariance.diagonal().cwiseSqrt();
      const StateVector off = Difference(asked->state, expected->state);
      EXPECT_LT(off.cwiseQuotient(sigmas).norm(), 0.2);
      const StateCovariance more = asked->covariance - expected->covariance;
      EXPECT_LT((more.array() / (sigmas * sigmas.transpose()).array()).abs().maxCoeff(), 0.1);
      EXPECT_EQ(Eigen::LLT<StateCovariance>(asked->covariance).info(), Eigen::Success);
    }
  }
}

// A recording that goes on long after the last tag: the far end stays within what is said of it.
TEST_P(TrajectoryTest, LongWithoutTagsTheCovarianceStaysTrue) {
  ExactModelOptions model = Model();
  model.frames = 60;
  const ExactModelFlight flight = DrawFlight(model);
  std::vector<FrameMeasurements> blind = flight.measurements;
  for (size_t i = 20; i < 45; ++i) blind[i].tags.clear();
  for (size_t i = 50; i < blind.size(); ++i) blind[i].tags.clear();
  const auto result = RunBatch(CourseSetUp(), GivenNoise(model), blind);
  ASSERT_TRUE(result) << result.error().message;
  for (const size_t i : {30, 44, 59}) {
    const StateVector e = Difference(result->frames[i].state, flight.truth[i]);
    EXPECT_LT(e.dot(result->frames[i].covariance.llt().solve(e)), 35.0) << i;
    EXPECT_GT(result->frames[i].covariance.trace(), 4 * result->frames[10].covariance.trace()) << i;
  }
}

// Where no tag says where two states are, both may be anywhere together, and the twist between them
// is as well known as if they were known to be here, as far as the covariances' digits go.
TEST_P(TrajectoryTest, WhatTwoStatesHaveInCommonSaysNothingOfTheTwistBetween) {
  ExactModelOptions model = Model();
  model.frames = 6;
  model.rate_hz = 10;
  const ExactModelFlight flight = DrawFlight(model);
  const auto result = RunBatch(CourseSetUp(), GivenNoise(model), flight.measurements);
  ASSERT_TRUE(result) << result.error().message;
  for (const auto& [anywhere_m, most] : {std::pair(1e3, 0.01), std::pair(1e12, 2.0)}) {
    Trajectory anywhere = result->trajectory;
    Block common = Block::Zero();
    common.block<3, 3>(3, 3).diagonal().setConstant(anywhere_m * anywhere_m);
    for (Block& covariance : anywhere.covariances) covariance += common;
    for (Block& covariance : anywhere.cross_covariances) covariance += common;
    for (const int64_t offset_ns : {1'000'000, 50'000'000, 99'000'000}) {
      const int64_t t_ns = flight.measurements[2].t_ns + offset_ns;
      const StateVector here = result->trajectory.At(t_ns)->covariance.diagonal(),
                        there = anywhere.At(t_ns)->covariance.diagonal();
      EXPECT_GT(there.minCoeff(), 0);
      const Eigen::ArrayXd ratio = there.cwiseQuotient(here);
      EXPECT_LT(ratio.tail<6>().log().abs().maxCoeff(), most) << anywhere_m << " " << offset_ns;
      EXPECT_LT(ratio.head<3>().log().abs().maxCoeff(), most) << anywhere_m << " " << offset_ns;
      EXPECT_NEAR(std::sqrt(there(3)) / anywhere_m, 1, 1e-6);
    }
  }
}

}  // namespace
}  // namespace tagtwist::internal::trajectory_test
