// Stretches without a tag, of a tenth of a second to five minutes, at the rates of usual cameras.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "estimator/window/sliding_window.h"
#include "frontend/types/nees.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal::gaps_test {
namespace {

struct Case {
  double rate_hz, gap_s;
};

class Gaps : public testing::TestWithParam<Case> {};

// A body that sways about the mat's middle.
Pose PoseAt(double t) {
  return Hover({0.9 + 0.15 * std::sin(1.3 * t), 0.9 + 0.12 * std::sin(0.9 * t + 1), 1.1},
               0.3 * std::sin(0.7 * t), {0.05 * std::sin(1.1 * t), 0.04, 0});
}

BodyState StateAt(double t) {
  constexpr double kDt = 1e-5;
  BodyState out;
  out.world_from_body = PoseAt(t);
  const Pose before = PoseAt(t - kDt), after = PoseAt(t + kDt);
  out.twist.v_world = (after.translation() - before.translation()) / (2 * kDt);
  out.twist.omega_body = LogSo3(before.rotation().conjugate() * after.rotation()) / (2 * kDt);
  return out;
}

TEST_P(Gaps, EndWithAStateThatHolds) {
  const auto [rate_hz, gap_s] = GetParam();
  constexpr double kBeforeS = 2, kAfterS = 1;
  const EstimatorSetup setup = CourseSetup();
  SlidingWindow window(SetUpOf(setup), setup.options);
  const auto n = static_cast<int>((kBeforeS + gap_s + kAfterS) * rate_hz);
  const auto first_after = static_cast<int>(std::ceil((kBeforeS + gap_s) * rate_hz));
  size_t lagged = 0, waits_most = 0;
  for (int k = 0; k < n; ++k) {
    const double t = k / rate_hz;
    const BodyState truth = StateAt(t);
    FrameMeasurements m;
    m.t_ns = 1'000'000'000 + std::llround(1e9 * t);
    if (t < kBeforeS || k >= first_after) {
      m.tags =
          SeeTags(setup.map, setup.camera, setup.cam_from_body * Inverse(truth.world_from_body),
                  0.2, static_cast<unsigned>(k));
    }
    const auto output = window.Add(m);
    ASSERT_TRUE(output) << output.error().message;
    lagged += output->lagged.size();
    waits_most = std::max(waits_most, static_cast<size_t>(k) + 1 - lagged);
    if (k < first_after) continue;
    ASSERT_NE(output->current.status, FrameStatus::kNoFix) << t;
    EXPECT_FALSE(IsBeyondFiveSigma(truth, output->current)) << t;
  }
  // What waits for its lagged state does not grow with the gap.
  EXPECT_LE(waits_most, 3 * static_cast<size_t>(setup.options.window_frames));
  EXPECT_EQ(lagged + window.Finish().size(), static_cast<size_t>(n));
}

// Set down, moved while nothing is seen, set down again: what is told meanwhile must not believe
// that it rests.
TEST(GapsFromRest, HoldsWhatIsMovedMeanwhile) {
  constexpr double kRestS = 3, kGapS = 1.2, kRateHz = 30;
  const EstimatorSetup setup = CourseSetup();
  double nees = 0;
  int predicted = 0, beyond = 0;
  for (const unsigned seed : {1, 2, 3}) {
    const auto pose_at = [=](double t) {
      const double f = std::clamp((t - kRestS) / kGapS, 0.0, 1.0);
      const double way = f * f * f * (10 - 15 * f + 6 * f * f);
      const double sign = seed % 2 == 0 ? 1 : -1;
      return Hover({0.9 + sign * 0.1 * way, 0.9 + 0.03 * seed * way, 1.1 - 0.05 * way},
                   0.3 + sign * 0.15 * seed * way, {0.05 * way, -0.04 * way, 0});
    };
    SlidingWindow window(SetUpOf(setup), setup.options);
    for (int k = 0; k < static_cast<int>((kRestS + kGapS + 1) * kRateHz); ++k) {
      const double t = k / kRateHz;
      const BodyState truth = StateAlong(pose_at, t);
      FrameMeasurements m;
      m.t_ns = 1'000'000'000 + std::llround(1e9 * t);
      if (t < kRestS - 0.1 || t > kRestS + kGapS + 0.1) {
        m.tags =
            SeeTags(setup.map, setup.camera, setup.cam_from_body * Inverse(truth.world_from_body),
                    0.2, 100 * seed + static_cast<unsigned>(k));
      }
      const auto output = window.Add(m);
      ASSERT_TRUE(output) << output.error().message;
      if (output->current.status != FrameStatus::kPredicted) continue;
      ++predicted, beyond += IsBeyondFiveSigma(truth, output->current) ? 1 : 0;
      nees += Nees(truth, output->current.state, output->current.covariance, kWholeState)
                  .value_or(1e9) /
              12;
    }
  }
  ASSERT_GT(predicted, 40);
  EXPECT_LT(nees, 2 * predicted);
  EXPECT_EQ(beyond, 0);
}

INSTANTIATE_TEST_SUITE_P(RatesAndLengths, Gaps,
                         testing::Values(Case{15, 1}, Case{30, 2}, Case{30, 300}, Case{60, 10},
                                         Case{120, 0.1}, Case{120, 30}));
INSTANTIATE_TEST_SUITE_P(SlowRatesAndLengths, Gaps,
                         testing::Values(Case{15, 0.1}, Case{15, 5}, Case{15, 300}, Case{30, 0.1},
                                         Case{30, 0.5}, Case{30, 20}, Case{60, 0.1}, Case{60, 3},
                                         Case{60, 300}, Case{120, 1}, Case{120, 4},
                                         Case{120, 300}));

}  // namespace
}  // namespace tagtwist::internal::gaps_test
