#include "estimator/motion/motion_breaks.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "estimator/batch/batch.h"
#include "estimator/start/recording_start.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal::motion_breaks_test {
namespace {

size_t BreaksOf(const SituationDraw& draw) {
  auto frames = StartFrames(draw.setup, draw.measurements);
  EXPECT_TRUE(frames);
  const auto told = MarkBreaks(draw.setup, &*frames);
  const auto n = std::count_if(frames->begin(), frames->end(),
                               [](const GraphFrame& frame) { return frame.motion.breaks; });
  EXPECT_EQ(told.has_value(), n > 0);
  return static_cast<size_t>(n);
}

TEST(MotionBreaks, AreWhereABodyWasCarriedAndNowhereElse) {
  for (const double rate_hz : {15.0, 90.0}) {
    EXPECT_EQ(BreaksOf(DrawSituation(Situation::kKidnapped, 61, rate_hz)), 1U);
    for (const Situation situation : {Situation::kSmooth, Situation::kHit, Situation::kStopAndGo,
                                      Situation::kJitter, Situation::kBursts, Situation::kGaps}) {
      EXPECT_EQ(BreaksOf(DrawSituation(situation, 61, rate_hz)), 0U)
          << NameOf(situation) << " at " << rate_hz << " Hz";
    }
  }
}

TEST(MotionBreaks, BatchBeginsAnewThere) {
  const SituationDraw draw = DrawSituation(Situation::kKidnapped, 62, 90);
  const auto estimate = RunBatch(SetUpOf(draw.setup), {}, draw.measurements);
  ASSERT_TRUE(estimate) << estimate.error().message;
  const SituationScore score = Judge(draw, estimate->frames);
  EXPECT_LT(score.nees, 1.3);
  EXPECT_LT(score.velocity_rms_mps, 0.1);
  EXPECT_LT(score.position_rms_m, 0.003);
  // Nobody knows when, between the two frames, nor which way.
  size_t last = 0;
  while (!estimate->trajectory.states.at(last + 1).motion.breaks) ++last;
  const auto& states = estimate->trajectory.states;
  const auto between = estimate->trajectory.At((states[last].t_ns + states[last + 1].t_ns) / 2);
  ASSERT_TRUE(between);
  EXPECT_GT(between->covariance.diagonal().segment<3>(3).minCoeff(), 1);
  ASSERT_FALSE(estimate->warnings.empty());
  EXPECT_NE(estimate->warnings.back().find("it was carried there"), std::string::npos);
}

}  // namespace
}  // namespace tagtwist::internal::motion_breaks_test
