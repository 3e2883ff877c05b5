#include "estimator/model_choice.h"

#include <gtest/gtest.h>

#include "estimator/batch.h"
#include "estimator/seeding.h"
#include "estimator/sliding_window.h"
#include "tests/exact_model.h"
#include "tests/simulated_flight.h"

namespace tagtwist {
namespace {

// It starts and stops smoothly and cruises between, and never turns: the attitude has nothing that
// a random walk of the rate would not explain.
TEST(ModelChoice, LinearAndAngularPartsAreChosenApart) {
  const EstimatorSetup setup = CourseSetup();
  const auto seeds = SeedFrames(setup, SimulateCorners("straight", 12).measurements);
  ASSERT_TRUE(seeds);
  const NoiseModel noise = ChooseNoise(setup, *seeds);
  EXPECT_EQ(noise.linear.on, WhiteNoiseOn::kJerk);
  EXPECT_EQ(noise.angular.on, WhiteNoiseOn::kAcceleration);
  EXPECT_LT(noise.angular.psd, 1e-6);
}

// The density of a motion that there is none of falls, but never so far that the prior's
// information, which grows as dt^-5, drowns the rest in rounding.
TEST(ModelChoice, AMotionlessAttitudeAtAHighRateIsSolved) {
  const auto measurements = SimulateCorners("straight", 2, 400).measurements;
  const auto batch = RunBatch(CourseSetup(), measurements);
  ASSERT_TRUE(batch) << batch.error().message;
  EXPECT_LT(batch->noise.angular.psd, 1e-5);
  SlidingWindow window(CourseSetup());
  for (const FrameMeasurements& m : measurements) {
    const auto out = window.Add(m);
    ASSERT_TRUE(out) << out.error().message;
  }
}

}  // namespace
}  // namespace tagtwist
