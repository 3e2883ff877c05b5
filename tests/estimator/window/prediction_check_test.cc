#include "estimator/window/prediction_check.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tagtwist::internal::prediction_check_test {
namespace {

constexpr double kRateHz = 50;
const MotionPrior kPrior{WhiteNoiseOn::kJerk, 1e-2};

GraphState AlongX(double t_s, double x, double v, double a) {
  GraphState state;
  state.t_ns = static_cast<int64_t>(1e9 * t_s);
  state.pose = MakePose(Eigen::Quaterniond::Identity(), {x, 0, 0});
  state.rates[0] = v;
  state.rates[6] = a;
  return state;
}

PredictionCheck AfterSine(double seconds) {
  PredictionCheck check;
  const Block exact = 1e-10 * Block::Identity();
  for (int i = 0; i < seconds * kRateHz; ++i) {
    const double t = i / kRateHz, w = 3;
    check.Add(AlongX(t, std::sin(w * t), w * std::cos(w * t), -w * w * std::sin(w * t)), exact,
              kPrior, kPrior);
  }
  return check;
}

TEST(PredictionCheck, NothingSeenInflatesNothing) {
  EXPECT_EQ(PredictionCheck().At(1).linear, 1);
  EXPECT_EQ(AfterSine(0.2).At(1).linear, 1);
}

// A sine at 3 rad/s: the jerk, 27 cos 3t, stays what it is for long.
TEST(PredictionCheck, GrowsWithTheGapWhereMotionIsNotWhite) {
  const PredictionCheck check = AfterSine(10);
  double last = 1;
  for (const double gap_s : {0.1, 0.25, 0.4, 0.5, 0.8, 1.0}) {
    const auto now = check.At(gap_s);
    EXPECT_GT(now.linear, last) << gap_s;
    EXPECT_EQ(now.angular, 1);  // it did not turn, and the prior allowed for more
    last = now.linear;
  }
  // States are kept every 0.06 s here, so what is 0.25 s back is 0.3 s back. By hand: x errs by j
  // h^3 / 6, v by j h^2 / 2, mean j^2 = 27^2 / 2, in one axis of three: j^2 [h^3/6 h^2/2] Q^-1
  // [..]' / 6 with Q = psd [h^5/20 h^4/8; h^4/8 h^3/3] is j^2 h / psd (1/36 / 3 - 2 / 12 / 8 + 1 /
  // 4 / 20) / (1/60 - 1/64) / 6 = 0.1481 j^2 h / psd.
  EXPECT_NEAR(check.At(0.25).linear / (0.14815 * 364.5 * 0.3 / 1e-2), 1, 0.05);
}

TEST(PredictionCheck, BeyondTheLongestHorizonItGoesOnAsASquare) {
  const PredictionCheck check = AfterSine(0.9);  // 0.5 s is the longest that was seen often enough
  const double half = check.At(0.5).linear;
  ASSERT_GT(half, 1);
  EXPECT_NEAR(check.At(1).linear, 1 + 4 * (half - 1), 1e-9 * half);
}

}  // namespace
}  // namespace tagtwist::internal::prediction_check_test
