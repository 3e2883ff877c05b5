#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/batch/batch.h"
#include "estimator/online/config.h"
#include "tests/support/flights/bench_flights.h"

namespace tagtwist::internal::solver_choice_test {
namespace {

// The noise that was found, as one that is given.
EstimatorOptions Given(const NoiseModel& noise, EstimatorOptions options) {
  const bool jerk = noise.linear.on == WhiteNoiseOn::kJerk;
  options.corner_sigma_px = noise.corner_sigma_px;
  options.track_sigma_px = noise.track_sigma_px;
  (jerk ? options.jerk_psd : options.accel_psd) = noise.linear.psd;
  (jerk ? options.angular_jerk_psd : options.angular_accel_psd) = noise.angular.psd;
  return options;
}

// A flight's measurements; its corners without a covariance of their own, so that what is learned
// is all of their noise.
std::vector<FrameMeasurements> Measured(const BenchFlight& flight, const Config& config) {
  const double duration_s = flight.simulator.images ? 1 : 2;  // images take their time
  auto run = MakeBenchRun(flight, config, duration_s, 1);
  if (!run) return {};
  for (FrameMeasurements& frame : run->measurements) {
    for (TagDetection& tag : frame.tags) tag.covariance.reset();
  }
  return std::move(run->measurements);
}

// The largest differences of states, in standard deviations, and of covariances, relative.
struct Differences {
  double state = 0, covariance = 0;
};

Differences Compare(const Estimate& found, const Estimate& expected) {
  Differences out;
  for (size_t i = 0; i < expected.frames.size(); ++i) {
    const FrameEstimate &a = found.frames[i], &b = expected.frames[i];
    const StateVector d = Difference(a.state, b.state);
    out.state = std::max(out.state, std::sqrt(d.dot(b.covariance.llt().solve(d))));
    out.covariance =
        std::max(out.covariance, (a.covariance - b.covariance).norm() / b.covariance.norm());
  }
  return out;
}

class SolverChoice : public testing::TestWithParam<size_t> {};
INSTANTIATE_TEST_SUITE_P(BenchFlights, SolverChoice, testing::Values<size_t>(0, 4));
INSTANTIATE_TEST_SUITE_P(SlowBenchFlights, SolverChoice, testing::Values<size_t>(1, 2, 3, 5));

// Whichever solves, the states and their covariances are the same; with tracks, where there are
// any, and without.
TEST_P(SolverChoice, CeresEndsWhereTheBandsDo) {
  const Config config = DefaultConfig();
  const BenchFlight flight = BenchGrid(0.2)[GetParam()];
  SCOPED_TRACE(flight.name);
  const std::vector<FrameMeasurements> measured = Measured(flight, config);
  ASSERT_FALSE(measured.empty());
  for (const bool use_tracks : {false, true}) {
    if (use_tracks && !flight.simulator.images) continue;
    EstimatorOptions options;
    options.clock = ClockChoice::kStamps;
    options.use_tracks = use_tracks;
    const auto learned = RunBatch(config.set_up, options, measured);
    ASSERT_TRUE(learned) << learned.error().message;
    options = Given(learned->noise, options);
    const auto by_bands = RunBatch(config.set_up, options, measured);
    options.solver = Solver::kCeres;
    const auto by_ceres = RunBatch(config.set_up, options, measured);
    ASSERT_TRUE(by_bands) << by_bands.error().message;
    ASSERT_TRUE(by_ceres) << by_ceres.error().message;
    const Differences found = Compare(*by_ceres, *by_bands);
    EXPECT_LT(found.state, 1e-7);
    EXPECT_LT(found.covariance, 1e-5);
  }
}

}  // namespace
}  // namespace tagtwist::internal::solver_choice_test
