#include "estimator/solve/noise_extrapolation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "estimator/batch/batch.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/imu_flight.h"

namespace tagtwist::internal::noise_extrapolation_test {
namespace {

// Every member away from its limit by `off`, in the logarithm.
NoiseModel Off(double off) {
  NoiseModel out;
  out.corner_sigma_px = 0.2 * std::exp(off);
  out.track_sigma_px = 0.4 * std::exp(-off);
  out.linear.psd = 3 * std::exp(off);
  out.angular.psd = 50 * std::exp(-off);
  return out;
}

void ExpectNear(const NoiseModel& a, const NoiseModel& b) {
  EXPECT_NEAR(a.corner_sigma_px / b.corner_sigma_px, 1, 1e-12);
  EXPECT_NEAR(a.track_sigma_px / b.track_sigma_px, 1, 1e-12);
  EXPECT_NEAR(a.linear.psd / b.linear.psd, 1, 1e-12);
  EXPECT_NEAR(a.angular.psd / b.angular.psd, 1, 1e-12);
}

TEST(NoiseExtrapolation, EverySecondRoundEndsAGeometricApproach) {
  NoiseExtrapolation rounds;
  ExpectNear(rounds.Next(Off(1), Off(0.5)), Off(0.5));
  ExpectNear(rounds.Next(Off(0.5), Off(0.25)), Off(0));
  ExpectNear(rounds.Next(Off(0.3), Off(0.2)), Off(0.2));  // begins anew
}

TEST(NoiseExtrapolation, StepsThatDoNotShrinkSteadilyAreTakenAsTheyAre) {
  for (const double second : {0.65, 0.499, 0.5}) {  // back, stopped nearly, stopped
    NoiseExtrapolation rounds;
    rounds.Next(Off(1), Off(0.5));
    ExpectNear(rounds.Next(Off(0.5), Off(second)), Off(second));
  }
  NoiseExtrapolation still;
  still.Next(Off(1), Off(1));
  ExpectNear(still.Next(Off(1), Off(0.5)), Off(0.5));
}

TEST(NoiseExtrapolation, AJumpIsAtMostAFactorOfESquared) {
  NoiseExtrapolation rounds;
  rounds.Next(Off(5), Off(4));
  ExpectNear(rounds.Next(Off(4), Off(3)), Off(1));
}

// A deviation that falls from 0.5 to 0.05 is cut short at 0.158 and carried on to 0.007; from there
// it is cut short again, and was carried on to 0.37, and so on: learned was what the last round
// left.
TEST(NoiseExtrapolation, AJumpThatWentTooFarIsNotMadeBackAgain) {
  NoiseExtrapolation rounds;
  const auto next = [&](double before_px, double updated_px) {
    NoiseModel before = Off(0), updated = Off(0);
    before.corner_sigma_px = before_px;
    updated.corner_sigma_px = updated_px;
    return rounds.Next(before, updated).corner_sigma_px;
  };
  const double cut_short = std::sqrt(0.1);
  next(0.5, 0.5 * cut_short);
  const double too_far_px = next(0.5 * cut_short, 0.05001);
  EXPECT_LT(too_far_px, 0.01);
  next(too_far_px, too_far_px / cut_short);
  EXPECT_EQ(next(too_far_px / cut_short, 0.05), 0.05);
}

TEST(NoiseExtrapolation, TheCornersOfAFlightAreLearnedAsTheyAre) {
  ImuFlightOptions options;
  options.duration_s = 3;
  options.corner_noise_px = 0.05;
  const auto solved = RunBatch(CourseSetUp(), {}, SimulateWithImu("hover", options).measurements);
  ASSERT_TRUE(solved);
  EXPECT_NEAR(solved->noise.corner_sigma_px, 0.05, 0.005);
}

}  // namespace
}  // namespace tagtwist::internal::noise_extrapolation_test
