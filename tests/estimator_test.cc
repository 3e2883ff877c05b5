#include <gtest/gtest.h>

#include <cmath>

#include "estimator/batch.h"
#include "estimator/sliding_window.h"
#include "tests/exact_model.h"

namespace tagtwist {
namespace {

double Nees(const FrameEstimate& estimate, const BodyState& truth) {
  const StateVector e = Difference(estimate.state, truth);
  return e.dot(estimate.covariance.llt().solve(e));
}

EstimatorOptions GivenNoise(const ExactModelOptions& model) {
  EstimatorOptions options;
  options.corner_sigma_px = model.corner_sigma_px;
  options.track_sigma_px = 0.3;
  options.accel_psd = model.accel_psd;
  options.angular_accel_psd = model.angular_accel_psd;
  return options;
}

struct WindowRun {
  std::vector<FrameEstimate> current, lagged;
};
WindowRun RunWindow(const EstimatorSetup& setup,
                    const std::vector<FrameMeasurements>& measurements) {
  SlidingWindow window(setup);
  WindowRun run;
  for (const FrameMeasurements& m : measurements) {
    auto out = window.Add(m);
    EXPECT_TRUE(out) << out.error().message;
    run.current.push_back(out->current);
    if (out->lagged) run.lagged.push_back(*out->lagged);
  }
  for (FrameEstimate& e : window.Finish()) run.lagged.push_back(std::move(e));
  return run;
}

TEST(Batch, WithoutNoiseItFindsTheTruth) {
  ExactModelOptions model;
  model.corner_sigma_px = 0;
  model.accel_psd = model.angular_accel_psd = 0;
  const ExactModelFlight flight = DrawFlight(model);
  model.corner_sigma_px = 1e-3, model.accel_psd = model.angular_accel_psd = 1e-3;
  const auto result = RunBatch(CourseSetup(GivenNoise(model)), flight.measurements);
  ASSERT_TRUE(result) << result.error().message;
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    EXPECT_LT(Difference(result->frames[i].state, flight.truth[i]).norm(), 1e-8) << i;
  }
}

TEST(Batch, CovarianceHoldsOnTheExactModel) {
  double sum = 0;
  int n = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    ExactModelOptions model;
    model.seed = seed;
    const ExactModelFlight flight = DrawFlight(model);
    const auto result = RunBatch(CourseSetup(GivenNoise(model)), flight.measurements);
    ASSERT_TRUE(result) << result.error().message;
    // States far apart in time are nearly independent draws.
    for (size_t i = 5; i < flight.truth.size(); i += 10, ++n) {
      sum += Nees(result->frames[i], flight.truth[i]);
    }
  }
  EXPECT_NEAR(sum / n, 12.0, 4 * std::sqrt(24.0 / n));
  RecordProperty("nees", std::to_string(sum / n));
  std::printf("batch NEES %.3f over %d\n", sum / n, n);
}

TEST(Window, CovarianceHoldsOnTheExactModel) {
  double sum_current = 0, sum_lagged = 0;
  int n = 0;
  for (unsigned seed = 21; seed <= 32; ++seed) {
    ExactModelOptions model;
    model.seed = seed;
    const ExactModelFlight flight = DrawFlight(model);
    const WindowRun run = RunWindow(CourseSetup(GivenNoise(model)), flight.measurements);
    for (size_t i = 5; i < flight.truth.size(); i += 10, ++n) {
      sum_current += Nees(run.current[i], flight.truth[i]);
      sum_lagged += Nees(run.lagged[i], flight.truth[i]);
    }
  }
  std::printf("window NEES %.3f lagged %.3f over %d\n", sum_current / n, sum_lagged / n, n);
  EXPECT_NEAR(sum_current / n, 12.0, 4 * std::sqrt(24.0 / n));
  EXPECT_NEAR(sum_lagged / n, 12.0, 4 * std::sqrt(24.0 / n));
}

TEST(Window, AsLongAsTheRecordingItEqualsBatch) {
  ExactModelOptions model;
  model.frames = 30;
  const ExactModelFlight flight = DrawFlight(model);
  EstimatorOptions options = GivenNoise(model);
  options.window_frames = 40;
  options.window_iterations = 20;
  const auto batch = RunBatch(CourseSetup(options), flight.measurements);
  ASSERT_TRUE(batch);
  const WindowRun run = RunWindow(CourseSetup(options), flight.measurements);
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    EXPECT_LT(Difference(run.lagged[i].state, batch->frames[i].state).norm(), 1e-6) << i;
    EXPECT_LT((run.lagged[i].covariance - batch->frames[i].covariance).norm(),
              1e-5 * batch->frames[i].covariance.norm())
        << i;
  }
}

TEST(Window, ShortItStaysNearBatch) {
  ExactModelOptions model;
  const ExactModelFlight flight = DrawFlight(model);
  const EstimatorOptions options = GivenNoise(model);
  const auto batch = RunBatch(CourseSetup(options), flight.measurements);
  ASSERT_TRUE(batch);
  const WindowRun run = RunWindow(CourseSetup(options), flight.measurements);
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    const StateVector d = Difference(run.lagged[i].state, batch->frames[i].state);
    EXPECT_LT(d.dot(batch->frames[i].covariance.llt().solve(d)), 12.0) << i;
  }
}

TEST(Noise, IsLearnedFromTheData) {
  ExactModelOptions model;
  model.frames = 300;
  model.accel_psd = 0.02;
  model.angular_accel_psd = 0.004;
  model.corner_sigma_px = 0.25;
  const ExactModelFlight flight = DrawFlight(model);
  const auto result = RunBatch(CourseSetup(), flight.measurements);
  ASSERT_TRUE(result) << result.error().message;
  std::printf("learned %.4f %.5f %.5f\n", result->noise.corner_sigma_px, result->noise.accel_psd,
              result->noise.angular_accel_psd);
  EXPECT_NEAR(result->noise.corner_sigma_px / model.corner_sigma_px, 1.0, 0.05);
  EXPECT_NEAR(result->noise.accel_psd / model.accel_psd, 1.0, 0.5);
  EXPECT_NEAR(result->noise.angular_accel_psd / model.angular_accel_psd, 1.0, 0.5);
  EXPECT_EQ(result->noise.source, "learned");
}

}  // namespace
}  // namespace tagtwist
