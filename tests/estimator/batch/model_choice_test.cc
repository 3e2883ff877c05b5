#include "estimator/batch/model_choice.h"

#include <gtest/gtest.h>

#include "estimator/graph/noise_model.h"
#include "estimator/solve/smoother.h"
#include "estimator/start/recording_start.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/simulated_flight.h"

namespace tagtwist::internal::model_choice_test {
namespace {

// It hovers, smoothly, between two stays at one place: a choice by the middle or by the ends alone
// would see one of the two.
TEST(ModelChoice, TheSampleIsSpreadOverTheRecording) {
  const EstimatorSetup setup = CourseSetup();
  auto frames = SimulateCorners("agile", 12).measurements;
  const auto moving = ChooseNoise(setup, *StartFrames(setup, frames));
  EXPECT_EQ(moving.linear.on, WhiteNoiseOn::kJerk);
  // The same second half, held still in between.
  const size_t half = frames.size() / 2;
  std::vector<FrameMeasurements> still(frames.begin(), frames.begin() + half);
  for (size_t i = 0; i < frames.size(); ++i) still.push_back(frames[half - 1]);
  for (size_t i = half; i < frames.size(); ++i) still.push_back(frames[i]);
  for (size_t i = 0; i < still.size(); ++i) still[i].t_ns = static_cast<int64_t>(i) * 20000000;
  const auto chosen = ChooseNoise(setup, *StartFrames(setup, still));
  EXPECT_GT(chosen.linear.psd, 1e-2 * moving.linear.psd);
}

// Stretches of a recording that is hardly longer than the sample do not overlap: a frame twice, or
// before the one that it follows, would leave no model standing.
TEST(ModelChoice, AJustLongEnoughRecordingIsChosenByAsWell) {
  ExactModelOptions model = ModelUnder(WhiteNoiseOn::kAcceleration, 4);
  for (const int frames : {301, 320, 345}) {
    model.frames = frames;
    const EstimatorSetup setup = CourseSetup();
    const auto chosen = ChooseNoise(setup, *StartFrames(setup, DrawFlight(model).measurements));
    EXPECT_EQ(chosen.linear.on, WhiteNoiseOn::kAcceleration) << frames;
  }
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
  input.frames = *StartFrames(setup, SimulateCorners("straight", 1, 400).measurements);
  for (const WhiteNoiseOn on : {WhiteNoiseOn::kAcceleration, WhiteNoiseOn::kJerk}) {
    NoiseModel noise = InitialNoise(setup.options, on);
    for (int round = 0; round < 40; ++round) noise = UpdateNoise(noise, motionless, setup.options);
    EXPECT_LT(noise.angular.psd, 0.1);
    const auto solution = SolveAndInvert(setup, noise, input, {50});
    EXPECT_TRUE(solution) << solution.error().message;
  }
}

}  // namespace
}  // namespace tagtwist::internal::model_choice_test
