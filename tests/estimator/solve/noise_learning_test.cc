#include "estimator/solve/noise_learning.h"

#include <gtest/gtest.h>

#include <cmath>

#include "residuals/motion_prior.h"

namespace tagtwist::internal::noise_learning_test {
namespace {

// Stamps that are a nanosecond to a microsecond apart, as of a clock in a wrong unit: the least
// density that can be reckoned with is above the largest that bodies have.
TEST(NoiseLearning, StatesNanosecondsApartKeepADensityThatCanBeReckonedWith) {
  for (const WhiteNoiseOn on : {WhiteNoiseOn::kAcceleration, WhiteNoiseOn::kJerk}) {
    for (const double step_s : {1e-9, 1e-6, 1e-5}) {
      NoiseModel noise;
      noise.linear = {on, 1.0};
      noise.angular = {on, 1.0};
      NoiseStatistics statistics;
      statistics.motions = 10;
      statistics.motion_s = 10 * step_s;
      statistics.linear = statistics.angular = {1e3, 1e3};
      const NoiseModel updated = UpdateNoise(noise, statistics, {}, 1.0);
      for (const double psd : {updated.linear.psd, updated.angular.psd}) {
        const double information = RootInformation({on, psd}, step_s)(0, 0);
        EXPECT_TRUE(std::isfinite(psd)) << step_s;
        EXPECT_LT(information * information, 1.001e18) << step_s;
      }
    }
  }
}

// The shake grows while its share of the residuals is larger than the rest's, and no further than a
// hand's tremor; where no state sees several tags, or the options say jerk, there is next to none.
TEST(NoiseLearning, TheShakeFollowsItsShareOfTheResiduals) {
  NoiseStatistics statistics;
  statistics.motions = 100;
  statistics.motion_s = 2;
  statistics.linear = statistics.angular = {1e3, 1e3};
  statistics.angular_shake = {{801, 99}, {99, 99}};
  NoiseModel noise = InitialNoise({});
  noise.linear.shake_s = noise.angular.shake_s = 0.004;
  const NoiseModel once = UpdateNoise(noise, statistics, {});
  EXPECT_NEAR(once.angular.shake_s, 0.004 * std::sqrt(8.02), 1e-9);
  EXPECT_NEAR(once.linear.shake_s, 0.002, 1e-12);  // a tenth of the interval
  EXPECT_NEAR(UpdateNoise(once, statistics, {}).angular.shake_s, 0.02, 1e-12);
  EstimatorOptions jerk;
  jerk.motion_prior = MotionPriorChoice::kJerk;
  EXPECT_EQ(UpdateNoise(InitialNoise(jerk), statistics, jerk).angular.shake_s, 0);
}

}  // namespace
}  // namespace tagtwist::internal::noise_learning_test
