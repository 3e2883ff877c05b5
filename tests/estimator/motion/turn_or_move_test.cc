#include "estimator/motion/turn_or_move.h"

#include <gtest/gtest.h>

#include "estimator/batch/batch.h"
#include "estimator/solve/noise_learning.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal::turn_or_move_test {
namespace {

std::vector<GraphFrame> TrueFrames(const SituationDraw& draw) {
  std::vector<GraphFrame> out(draw.truth.size());
  for (size_t k = 0; k < out.size(); ++k) {
    out[k].t_ns = draw.measurements[k].t_ns;
    out[k].state = draw.truth[k];
    out[k].tags = draw.measurements[k].tags;
  }
  return out;
}

TEST(TurnOrMove, ALoneFarTagDoesNotTellAndAMatDoes) {
  NoiseModel noise;
  noise.corner_sigma_px = 0.2;
  const SituationDraw far = DrawSituation(Situation::kFarTag, 212);
  EXPECT_NEAR(LeverOfUntold(far.setup, noise, TrueFrames(far)), 2.5, 0.1);  // it hovers at 2.5 m
  for (const Situation told : {Situation::kSmooth, Situation::kRest, Situation::kTwin}) {
    const SituationDraw draw = DrawSituation(told, 3);
    EXPECT_EQ(LeverOfUntold(draw.setup, noise, TrueFrames(draw)), 0) << NameOf(told);
  }
}

TEST(TurnOrMove, TheDensitiesAreOneByTheLever) {
  NoiseStatistics statistics;
  statistics.linear = {1e-9, 1000};  // the data want none of the one
  statistics.angular = {200, 1000};
  statistics.motion_s = 1;
  statistics.motions = 30;
  NoiseModel noise;
  noise.lever_m = 2;
  for (int round = 0; round < 40; ++round) noise = UpdateNoise(noise, statistics, {});
  EXPECT_NEAR(noise.angular.psd, 0.2, 1e-9);
  EXPECT_NEAR(noise.linear.psd, 0.8, 1e-9);
  EstimatorOptions given;
  given.jerk_psd = 5;
  noise.linear.psd = 5;
  noise = UpdateNoise(noise, statistics, given);
  EXPECT_EQ(noise.linear.psd, 5);
  EXPECT_NEAR(noise.angular.psd, 0.2, 1e-9);
}

// Turning alone explains what turned and moved together, and has less to explain: of these the
// first was surely wrong (NEES 8), the second came to a density that nothing can be solved with.
TEST(TurnOrMove, BatchIsNotSureOfATurnThatMayHaveBeenAMove) {
  for (const unsigned seed : {83U, 212U}) {
    const SituationDraw draw = DrawSituation(Situation::kFarTag, seed);
    const auto out = RunBatch(SetUpOf(draw.setup), {}, draw.measurements);
    ASSERT_TRUE(out) << out.error().message;
    const SituationScore score = Judge(draw, out->frames);
    EXPECT_GT(out->noise.lever_m, 0);
    EXPECT_LT(score.nees, 2) << seed;
    EXPECT_LT(score.beyond, 0.01) << seed;
  }
}

}  // namespace
}  // namespace tagtwist::internal::turn_or_move_test
