#include "estimator/window/stamp_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "estimator/batch/batch.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/window_run.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal::stamp_check_test {
namespace {

constexpr int64_t kMs = 1'000'000;

TEST(StampCheck, EveryOtherFrameOfPairsComesTooSoon) {
  StampCheck check;
  int too_soon = 0;
  for (int64_t pair = 0; pair < 50; ++pair) {
    check.ComesTooSoon(66 * pair * kMs);
    too_soon += check.ComesTooSoon(66 * pair * kMs + kMs / 2) ? 1 : 0;
  }
  EXPECT_GE(too_soon, 45);  // the first ones show what is usual
  ASSERT_TRUE(check.Warning());
  EXPECT_NE(check.Warning()->find(std::to_string(too_soon) + " frames"), std::string::npos);
}

TEST(StampCheck, GapsJitterAndOtherRatesAreNoBursts) {
  StampCheck check;
  int64_t t_ns = 0;
  for (int64_t i = 0; i < 300; ++i) {
    EXPECT_FALSE(check.ComesTooSoon(t_ns)) << i;
    // 30 Hz with a third of jitter, a gap, then 120 Hz.
    t_ns += i == 100 ? 20'000 * kMs : i < 200 ? (i % 2 == 0 ? 22 : 44) * kMs : 8 * kMs;
  }
  EXPECT_FALSE(check.Warning());
}

// A smooth flight whose host takes so many frames at a time, late by some jitter, and stamps them
// shortly after one another.
SituationDraw DrawBursts(size_t at_a_time, unsigned seed) {
  SituationDraw draw = DrawSituation(Situation::kSmooth, seed, seed % 2 == 0 ? 30 : 60);
  draw.truth.resize(240);
  draw.measurements.resize(240);
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  const double apart_s = std::pow(10, -4 + 1.2 * uniform(engine)),
               jitter_s = std::pow(10, -5 + 2 * uniform(engine));
  int64_t at_host_ns = 0;
  std::vector<FrameMeasurements>& all = draw.measurements;
  for (size_t k = 0; k < all.size(); ++k) {
    if (k % at_a_time == 0) {
      at_host_ns = all[std::min(k + at_a_time, all.size()) - 1].t_ns +
                   static_cast<int64_t>(1e9 * jitter_s * uniform(engine));
    }
    all[k].t_ns = at_host_ns + static_cast<int64_t>(1e9 * apart_s) * (k % at_a_time);
  }
  return draw;
}

// From the first frame on: what stamps say of the motion before anybody knows them is not told.
TEST(Bursts, AreHonestFromTheFirstFrameOn) {
  for (const unsigned seed : {1, 2, 3}) {
    const SituationDraw draw = DrawBursts(seed == 1 ? 3 : 2, seed);
    const WindowRun run = RunWindow(draw.setup, draw.measurements);
    for (const auto* frames : {&run.current, &run.lagged}) {
      const SituationScore score = Judge(draw, *frames);
      EXPECT_GT(score.nees, 0.4) << seed;
      EXPECT_LT(score.nees, 2) << seed;
      EXPECT_LE(score.beyond, 0.01) << seed;
    }
  }
}

TEST(Bursts, OfThreeAreSteadiedInBatch) {
  const SituationDraw draw = DrawBursts(3, 4);
  const auto estimate = RunBatch(SetUpOf(draw.setup), draw.setup.options, draw.measurements);
  ASSERT_TRUE(estimate);
  const SituationScore score = Judge(draw, estimate->frames);
  EXPECT_LT(score.nees, 1.3);
  EXPECT_EQ(score.beyond, 0);
}

}  // namespace
}  // namespace tagtwist::internal::stamp_check_test
