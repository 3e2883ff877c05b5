#include <gtest/gtest.h>

#include <cmath>

#include "estimator/batch/batch.h"
#include "estimator/window/sliding_window.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/window_run.h"

namespace tagtwist::internal::estimator_test {
namespace {

double Nees(const FrameEstimate& estimate, const BodyState& truth) {
  const StateVector e = Difference(estimate.state, truth);
  return e.dot(estimate.covariance.llt().solve(e));
}

TEST(Batch, WithoutNoiseItFindsTheTruth) {
  ExactModelOptions model;
  model.corner_sigma_px = 0;
  model.linear.psd = model.angular.psd = 0;
  const ExactModelFlight flight = DrawFlight(model);
  model.corner_sigma_px = 1e-3, model.linear.psd = model.angular.psd = 1e-3;
  const auto result = RunBatch(CourseSetUp(), GivenNoise(model), flight.measurements);
  ASSERT_TRUE(result) << result.error().message;
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    EXPECT_LT(Difference(result->frames[i].state, flight.truth[i]).norm(), 1e-8) << i;
  }
}

class ExactModel : public UnderBothPriors {};
INSTANTIATE_UNDER_BOTH_PRIORS(ExactModel);

TEST_P(ExactModel, CovarianceOfBatchHolds) {
  double sum = 0;
  int n = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const ExactModelOptions model = Model(seed);
    const ExactModelFlight flight = DrawFlight(model);
    const auto result = RunBatch(CourseSetUp(), GivenNoise(model), flight.measurements);
    ASSERT_TRUE(result) << result.error().message;
    // States far apart in time are nearly independent draws.
    for (size_t i = 5; i < flight.truth.size(); i += 10, ++n) {
      sum += Nees(result->frames[i], flight.truth[i]);
    }
  }
  EXPECT_NEAR(sum / n, 12.0, 4 * std::sqrt(24.0 / n));
}

TEST_P(ExactModel, CovarianceOfTheWindowHolds) {
  double sum_current = 0, sum_lagged = 0;
  int n = 0;
  for (unsigned seed = 21; seed <= 32; ++seed) {
    const ExactModelOptions model = Model(seed);
    const ExactModelFlight flight = DrawFlight(model);
    const WindowRun run = RunWindow(CourseSetup(GivenNoise(model)), flight.measurements);
    for (size_t i = 5; i < flight.truth.size(); i += 10, ++n) {
      sum_current += Nees(run.current[i], flight.truth[i]);
      sum_lagged += Nees(run.lagged[i], flight.truth[i]);
    }
  }
  EXPECT_NEAR(sum_current / n, 12.0, 4 * std::sqrt(24.0 / n));
  EXPECT_NEAR(sum_lagged / n, 12.0, 4 * std::sqrt(24.0 / n));
}

TEST_P(ExactModel, SlowCovarianceOfThePredictionHolds) {
  double sum = 0;
  int n = 0;
  for (unsigned seed = 41; seed <= 52; ++seed) {
    const ExactModelOptions model = Model(seed);
    const ExactModelFlight flight = DrawFlight(model);
    SlidingWindow window(CourseSetUp(), GivenNoise(model));
    EXPECT_FALSE(window.PredictAt(0));
    for (size_t i = 0; i < flight.truth.size(); ++i) {
      const FrameMeasurements& measurement = flight.measurements[i];
      if (i % 10 == 5) {
        const auto predicted = window.PredictAt(measurement.t_ns);
        ASSERT_TRUE(predicted);
        FrameEstimate next;
        next.state = predicted->state;
        next.covariance = predicted->covariance;
        sum += Nees(next, flight.truth[i]);
        ++n;
      }
      ASSERT_TRUE(window.Add(measurement));
    }
  }
  EXPECT_NEAR(sum / n, 12.0, 4 * std::sqrt(24.0 / n));
}

TEST_P(ExactModel, AWindowAsLongAsTheRecordingEqualsBatch) {
  ExactModelOptions model = Model();
  model.frames = 30;
  const ExactModelFlight flight = DrawFlight(model);
  EstimatorOptions options = GivenNoise(model);
  options.window_frames = 40;
  options.window_iterations = 20;
  const auto batch = RunBatch(CourseSetUp(), options, flight.measurements);
  ASSERT_TRUE(batch);
  const WindowRun run = RunWindow(CourseSetup(options), flight.measurements);
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    EXPECT_LT(Difference(run.lagged[i].state, batch->frames[i].state).norm(), 1e-6) << i;
    EXPECT_LT((run.lagged[i].covariance - batch->frames[i].covariance).norm(),
              1e-5 * batch->frames[i].covariance.norm())
        << i;
  }
}

TEST_P(ExactModel, AShortWindowStaysNearBatch) {
  const ExactModelOptions model = Model();
  const ExactModelFlight flight = DrawFlight(model);
  const EstimatorOptions options = GivenNoise(model);
  const auto batch = RunBatch(CourseSetUp(), options, flight.measurements);
  ASSERT_TRUE(batch);
  const WindowRun run = RunWindow(CourseSetup(options), flight.measurements);
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    const StateVector d = Difference(run.lagged[i].state, batch->frames[i].state);
    EXPECT_LT(d.dot(batch->frames[i].covariance.llt().solve(d)), 12.0) << i;
  }
}

// The prior that the flight was drawn from is found, and its densities.
TEST_P(ExactModel, SlowNoiseIsLearnedFromTheData) {
  double linear = 0, angular = 0;
  constexpr int kFlights = 5;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    ExactModelOptions model = Model(seed);
    const bool jerk = GetParam() == WhiteNoiseOn::kJerk;
    model.frames = jerk ? 150 : 300;  // not long enough to get far from the mat
    model.linear.psd = jerk ? 0.1 : 0.02;
    model.angular.psd = jerk ? 0.05 : 0.004;
    model.corner_sigma_px = 0.25;
    const ExactModelFlight flight = DrawFlight(model);
    const auto result = RunBatch(CourseSetUp(), {}, flight.measurements);
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_NEAR(result->noise.corner_sigma_px / model.corner_sigma_px, 1.0, 0.05);
    EXPECT_EQ(result->noise.linear.on, GetParam());
    EXPECT_EQ(result->noise.angular.on, GetParam());
    EXPECT_EQ(result->noise.source, NoiseSource::kLearned);
    linear += result->noise.linear.psd / model.linear.psd / kFlights;
    angular += result->noise.angular.psd / model.angular.psd / kFlights;
  }
  EXPECT_NEAR(linear, 1.0, 0.35);
  EXPECT_NEAR(angular, 1.0, 0.35);
}

}  // namespace
}  // namespace tagtwist::internal::estimator_test
