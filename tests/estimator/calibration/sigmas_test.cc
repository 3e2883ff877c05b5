// Sigmas of calibrated parameters from blocks of time: right on white corner noise, and on corner
// errors that last over frames, where white noise's are not.
#include "estimator/calibration/sigmas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <random>
#include <unordered_map>

#include "tests/support/draws.h"
#include "tests/support/flights/calibration_flight.h"

namespace tagtwist::internal::sigmas_test {
namespace {

using testing::AllOf;
using testing::Gt;
using testing::Lt;

// Of the free parameters, a degree of freedom: by the solution's own covariance, and by blocks.
struct Nees {
  double white = 0, blocks = 0;
};

// Over eight frames, 1.1 s, a tag's corners keep an error of that size.
void AddLastingErrors(double sigma_px, unsigned seed, std::vector<FrameMeasurements>* frames) {
  constexpr size_t kLasts = 8;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::unordered_map<int, std::array<Eigen::Vector2d, 4>> errors;
  for (size_t i = 0; i < frames->size(); ++i) {
    if (i % kLasts == 0) errors.clear();
    for (TagDetection& tag : (*frames)[i].tags) {
      const auto [at, is_new] = errors.try_emplace(tag.id);
      for (Eigen::Vector2d& error : at->second) {
        if (is_new) error = sigma_px * DrawVector<2>(normal, random);
      }
      for (size_t c = 0; c < 4; ++c) tag.corners[c] += at->second[c];
    }
  }
}

Nees NeesOf(double lasting_px, unsigned seed) {
  CalibrationFlightOptions options = ShortFlight();
  options.frames = 200;
  options.random_seed = seed;
  CalibrationFlight flight = DrawCalibrationFlight(options);
  AddLastingErrors(lasting_px, seed, &flight.measurements);
  auto problem = MakeCalibrationProblem(CalibrationInputOf(flight.config), flight.measurements, {});
  EXPECT_TRUE(problem);
  CalibrationSolution solution =
      SolveAndLearnNoise(*problem, problem->prior, CalibrationNoise(), true);
  EXPECT_TRUE(solution.usable);
  SetCornerNoise(solution.noise.corner_sigma_px, &solution.frames);
  std::vector<int> free;
  for (Eigen::Index i = 0; i < problem->prior_sigmas.size(); ++i) {
    if (problem->prior_sigmas(i) > 0) free.push_back(static_cast<int>(i));
  }
  const Eigen::VectorXd error = Difference(solution.state, flight.truth)(free);
  const auto nees = [&](const Eigen::MatrixXd& covariance) {
    const Eigen::MatrixXd of_free = covariance(free, free);
    return error.dot(of_free.ldlt().solve(error)) / static_cast<double>(free.size());
  };
  return {nees(solution.covariance), nees(BlockCovariance(*problem, solution))};
}

Nees MeanOver(double lasting_px, unsigned draws) {
  Nees out;
  for (unsigned seed = 1; seed <= draws; ++seed) {
    const Nees of_draw = NeesOf(lasting_px, seed);
    out.white += of_draw.white / draws;
    out.blocks += of_draw.blocks / draws;
  }
  return out;
}

TEST(BlockCovariance, SlowOnWhiteNoiseItIsTheSolutionsOwn) {
  const Nees nees = MeanOver(0, 3);
  EXPECT_THAT(nees.white, AllOf(Gt(0.8), Lt(1.2)));
  EXPECT_THAT(nees.blocks, AllOf(Gt(0.9 * nees.white), Lt(1.001 * nees.white)));
  RecordProperty("blocks", std::to_string(nees.blocks));
}

TEST(BlockCovariance, SlowOfErrorsThatLastItIsAsWideAsTheyAre) {
  const Nees nees = MeanOver(0.3, 3);
  EXPECT_GT(nees.white, 2.5);
  EXPECT_THAT(nees.blocks, AllOf(Gt(0.7), Lt(1.4))) << nees.white;
  RecordProperty("white", std::to_string(nees.white));
  RecordProperty("blocks", std::to_string(nees.blocks));
}

TEST(BlockCovariance, OfTooShortARecordingItIsTheSolutionsOwn) {
  CalibrationFlightOptions options = ShortFlight();
  options.frames = 21;
  options.rate_hz = 20;
  const CalibrationFlight flight = DrawCalibrationFlight(options);
  const auto problem =
      MakeCalibrationProblem(CalibrationInputOf(flight.config), flight.measurements, {});
  ASSERT_TRUE(problem) << problem.error().message;
  const CalibrationSolution solution =
      SolveAndLearnNoise(*problem, problem->prior, CalibrationNoise(), true);
  ASSERT_TRUE(solution.usable);
  EXPECT_EQ(BlockCovariance(*problem, solution), solution.covariance);
}

}  // namespace
}  // namespace tagtwist::internal::sigmas_test
