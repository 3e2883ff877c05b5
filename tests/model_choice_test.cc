#include "estimator/model_choice.h"

#include <gtest/gtest.h>

#include "estimator/seeding.h"
#include "estimator/smoother.h"
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

// A density that the data want to be zero falls until the prior's information, which grows as
// dt^-5, would drown the rest in rounding, and no further.
TEST(ModelChoice, TheLeastDensityCanBeSolvedWith) {
  const EstimatorSetup setup = CourseSetup();
  NoiseStatistics motionless;
  motionless.angular = {0, 1000};
  motionless.motion_s = 1;
  motionless.motions = 400;
  GraphInput input;
  input.frames = *SeedFrames(setup, SimulateCorners("straight", 1, 400).measurements);
  for (const WhiteNoiseOn on : {WhiteNoiseOn::kAcceleration, WhiteNoiseOn::kJerk}) {
    NoiseModel noise = InitialNoise(setup.options, {WhiteNoiseOn::kJerk, on});
    for (int round = 0; round < 40; ++round) noise = UpdateNoise(noise, motionless, setup.options);
    EXPECT_LT(noise.angular.psd, 0.1);
    const auto solution = SolveAndInvert(setup, noise, input, {50});
    EXPECT_TRUE(solution) << solution.error().message;
  }
}

}  // namespace
}  // namespace tagtwist
