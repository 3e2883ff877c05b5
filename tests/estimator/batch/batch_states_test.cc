#include "estimator/batch/batch_states.h"

#include <gtest/gtest.h>

#include "estimator/batch/uneven_motion.h"
#include "estimator/graph/linear_system.h"
#include "estimator/motion/open_motion_of_chain.h"
#include "estimator/motion/unfollowed_motion.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/noise_rounds.h"
#include "estimator/solve/prior_power.h"
#include "estimator/start/recording_start.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal::batch_states_test {
namespace {

// A body that rests and then takes off, solved under one density.
struct TakeOff {
  SituationDraw draw = DrawSituation(Situation::kTakeOff, 5);
  GraphInput input;
  NoiseModel noise = InitialNoise(draw.setup.options);
  Solution solution;

  TakeOff() {
    input.frames = *StartFrames(draw.setup, draw.measurements);
    solution = *SolveAndLearn(draw.setup, {50}, &input, &noise);
  }
};

void ExpectTheSame(const Graph& graph, const Graph& before) {
  ASSERT_EQ(graph.factors.size(), before.factors.size());
  const LinearSystem a = Linearize(graph), b = Linearize(before);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.gradient, b.gradient);
  for (int k = 0; k < a.hessian.size(); ++k) EXPECT_EQ(a.hessian.At(k, k), b.hessian.At(k, k));
}

TEST(StateCovariances, AreScaledByThePowerThatTheGraphShows) {
  TakeOff flight;
  const PriorPower prior = FindPriorPower(flight.solution.graph);
  const auto found =
      StateCovariances(flight.draw.setup, flight.noise, flight.input.frames, flight.solution);
  auto expected = WithPriorPower(prior.statistic.Power(), prior);
  AddOpenMotion({flight.solution.graph.states, flight.solution.covariance, flight.noise},
                {true, true}, InOneRange, &expected);
  AddUnfollowedMotion(flight.draw.setup, flight.noise.corner_sigma_px, {true, true},
                      flight.solution.graph.states, flight.input.frames, &expected);
  EXPECT_EQ(found, expected);
}

TEST(UnevenMotion, ASecondSolutionThatIsNoBetterLeavesTheFirst) {
  TakeOff flight;
  const GraphInput input = flight.input;
  const Graph before = flight.solution.graph;
  const NoiseModel noise = flight.noise;
  NoiseModel varied_noise = noise;
  GraphInput varied = input;
  const auto better =
      LetMotionVary(flight.draw.setup, {50}, flight.solution, &varied, &varied_noise);
  ASSERT_TRUE(better) << better.error().message;
  EXPECT_NE(varied.frames.back().motion.linear, 1) << "the motion varies";
  Solution first = flight.solution;
  first.log_likelihood = 1e9;  // no second one is better
  const auto kept = LetMotionVary(flight.draw.setup, {50}, first, &flight.input, &flight.noise);
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_EQ(flight.noise.linear.psd, noise.linear.psd);
  for (size_t k = 0; k < input.frames.size(); ++k) {
    EXPECT_EQ(flight.input.frames[k].motion.linear, 1);
    EXPECT_EQ(flight.input.frames[k].state.world_from_body.params,
              input.frames[k].state.world_from_body.params);
  }
  ExpectTheSame(kept->graph, before);
  ASSERT_EQ(kept->covariance.size(), first.covariance.size());
  for (int k = 0; k < first.covariance.size(); ++k) {
    EXPECT_TRUE(kept->covariance.At(k, k).isApprox(first.covariance.At(k, k), 1e-7)) << k;
  }
}

}  // namespace
}  // namespace tagtwist::internal::batch_states_test
