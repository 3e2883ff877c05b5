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

// A deviation that falls from 0.5 to 0.05 is cut short at 0.158: it was carried on to 0.007 and
// back to 0.37, and so on, and learned as whatever the last round left.
TEST(NoiseExtrapolation, StepsOfADeviationThatWereCutShortAreNotCarriedOn) {
  NoiseModel models[3] = {Off(0), Off(0), Off(0)};
  const double sigmas_px[3] = {0.5, 0.5 * std::sqrt(0.1), 0.05001};
  for (int i = 0; i < 3; ++i) models[i].corner_sigma_px = sigmas_px[i];
  NoiseExtrapolation rounds;
  rounds.Next(models[0], models[1]);
  EXPECT_EQ(rounds.Next(models[1], models[2]).corner_sigma_px, sigmas_px[2]);
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
