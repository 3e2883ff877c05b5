#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "estimator/calibration/calibration.h"
#include "estimator/calibration/solver.h"
#include "estimator/online/config_text.h"
#include "estimator/report/files/calibration_config.h"
#include "estimator/report/files/calibration_json.h"
#include "estimator/report/files/calibration_text.h"
#include "frontend/base/statistics/chi_square.h"
#include "tests/support/flights/calibration_flight.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::calibration_extras_test {
namespace {

// Images alone, everything else free; 10 flights.
TEST(SlowCalibration, BendsOfTheTagsAreChiSquare) {
  constexpr int kFlights = 10;
  double bends_nees = 0, nees = 0;
  int bends = 0, within = 0, dof = 0;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    CalibrationFlightOptions options = ShortFlight();
    options.tag_bend_sigma = kBendSigma;
    options.random_seed = seed;
    const CalibrationFlight flight = DrawCalibrationFlight(options);
    const auto problem =
        MakeCalibrationProblem(CalibrationInputOf(flight.config), flight.measurements, {});
    ASSERT_TRUE(problem) << problem.error().message;
    const CalibrationSolution solution =
        SolveAndLearnNoise(*problem, problem->prior, CalibrationNoise(), true);
    ASSERT_TRUE(solution.usable);
    const CalibrationLayout layout = LayoutOf(flight.truth);
    const Eigen::VectorXd all_errors = Difference(solution.state, flight.truth);
    std::vector<int> of_bends, free;
    for (int i = 0; i < layout.size(); ++i) {
      if (problem->prior_sigmas(i) > 0) free.push_back(i);
    }
    for (int i = 0; i < layout.n_tags; ++i) {
      of_bends.push_back(layout.bend(i));
      const double sigma = std::sqrt(solution.covariance(layout.bend(i), layout.bend(i)));
      EXPECT_LT(sigma, 0.5 * problem->prior_sigmas(layout.bend(i)));
      within += std::abs(all_errors(layout.bend(i))) < 3 * sigma ? 1 : 0;
    }
    const auto nees_of = [&](const std::vector<int>& entries) {
      const Eigen::VectorXd error = all_errors(entries);
      const Eigen::MatrixXd covariance = solution.covariance(entries, entries);
      return error.dot(covariance.ldlt().solve(error));
    };
    bends_nees += nees_of(of_bends);
    nees += nees_of(free);
    bends += layout.n_tags;
    dof += static_cast<int>(free.size());
  }
  EXPECT_GE(within, 0.95 * bends);
  const auto [low, high] = MeanChiSquareBand(bends, 1);
  EXPECT_GT(bends_nees, low);
  EXPECT_LT(bends_nees, high);
  const auto [all_low, all_high] = MeanChiSquareBand(dof, 1);
  EXPECT_GT(nees, all_low);
  EXPECT_LT(nees, all_high);
}

TEST(Calibration, BendsAreAppliedAndWrittenWhereTheyHelp) {
  CalibrationFlightOptions options = ShortFlight();
  options.tag_bend_sigma = 2 * kBendSigma;
  const CalibrationFlight flight = DrawCalibrationFlight(options);
  const auto result = Calibrate(CalibrationInputOf(flight.config), flight.measurements, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_GT(Gain(*result, CalibrationGroup::kBend), 0);
  EXPECT_TRUE(Says(CalibrationText(*result), "tags are bent by "));
  EXPECT_TRUE(Says(CalibrationText(*result), " is bent by "));
  const std::vector<TagBend> bends = TagBends(*result);
  ASSERT_EQ(bends.size(), 16u);
  EXPECT_EQ(CalibrationJson(*result)["bends"][3]["bend_m"], bends[3].bend_m);
  const TempFolder folder;
  WriteText(folder / "calibration.yaml",
            FormatCalibrationConfig(*result, OptionsText(flight.config)));
  const auto config = LoadConfig(folder / "calibration.yaml");
  ASSERT_TRUE(config) << config.error().message;
  for (size_t i = 0; i < bends.size(); ++i) {
    EXPECT_NEAR(bends[i].bend_m, flight.truth.tags[i].bend_m, 4 * bends[i].sigma_m);
    const int id = bends[i].id;
    for (size_t c = 0; c < 4; ++c) {
      const Eigen::Vector3d &read = config->set_up.map.CornersInWorld(id)[c],
                            &written = result->set_up.map.CornersInWorld(id)[c];
      EXPECT_LT((read - written).norm(), 1e-12);
    }
  }
}

TEST(Calibration, AppliedMapIsTheScaledOneInTheTruthsWorld) {
  CalibrationFlightOptions options = ShortFlight();
  options.frames = 1;
  options.tag_bend_sigma = 10 * kBendSigma;
  const CalibrationFlight flight = DrawCalibrationFlight(options);
  CalibrationState state = flight.truth;
  state.log_scale = 0.3;
  state.truth_from_world = MakePose(Eigen::Quaterniond(0.8, 0, 0.6, 0), {1, 2, 3});
  const auto applied = Apply(flight.config.set_up, state);
  for (const Tag& tag : state.tags) {
    EXPECT_GT(std::abs(tag.bend_m), 1e-6);
    const auto corners = TagCornersInWorld(tag);
    for (size_t c = 0; c < 4; ++c) {
      const Eigen::Vector3d expected = state.truth_from_world * (std::exp(0.3) * corners[c]);
      EXPECT_LT((applied.map.CornersInWorld(tag.id)[c] - expected).norm(), 1e-12);
    }
  }
}

// Plane tags, whose poses and lens are not as configured.
TEST(SlowCalibration, BendsOfPlaneTagsAreNotApplied) {
  const CalibrationFlight flight = DrawCalibrationFlight(ShortFlight());
  Config config = flight.config;
  config.calibration.tag_bend_sigma = kBendSigma;
  const auto result = Calibrate(CalibrationInputOf(config), flight.measurements, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_GT(Gain(*result, CalibrationGroup::kMap), 0);
  EXPECT_TRUE(Says(CalibrationText(*result), "bends of the tags: not applied"));
  EXPECT_TRUE(TagBends(*result).empty());
  const CalibrationLayout layout = LayoutOf(flight.truth);
  for (int i = 0; i < layout.n_tags; ++i) {
    EXPECT_EQ(result->set_up.map.tags()[static_cast<size_t>(i)].bend_m, 0);
    // What the recording says of them is known, though it is not applied.
    EXPECT_LT(result->sigma(layout.bend(i)), 0.3 * result->prior_sigmas(layout.bend(i)));
  }
}

// Images alone, everything else free; 20 flights.
TEST(SlowCalibration, LineTimeOfARollingShutterIsChiSquare) {
  constexpr int kFlights = 20;
  double squares = 0;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    CalibrationFlightOptions options = ShortFlight();
    options.frames = 60;
    options.rate_hz = 20;
    options.line_time_s = 5e-5;  // 12 ms an image
    options.random_seed = seed;
    CalibrationFlight flight = DrawCalibrationFlight(options);
    flight.config.calibration.line_time_sigma_s = 5e-5;
    const auto problem =
        MakeCalibrationProblem(CalibrationInputOf(flight.config), flight.measurements, {});
    ASSERT_TRUE(problem) << problem.error().message;
    const CalibrationSolution solution =
        SolveAndLearnNoise(*problem, problem->prior, CalibrationNoise(), true);
    ASSERT_TRUE(solution.usable);
    const int entry = LayoutOf(flight.truth).line_time();
    const double sigma = std::sqrt(solution.covariance(entry, entry));
    EXPECT_LT(sigma, 2.5e-6);
    const double error = (solution.state.line_time_s - 5e-5) / sigma;
    EXPECT_LT(std::abs(error), 3.5);
    EXPECT_NEAR(solution.noise.corner_sigma_px, 0.15, 0.012);
    squares += error * error;
  }
  const auto [low, high] = MeanChiSquareBand(kFlights, 1);
  EXPECT_GT(squares, low);
  EXPECT_LT(squares, high);
}

TEST(Calibration, LineTimeIsAppliedAndWrittenWhereItHelps) {
  CalibrationFlightOptions options = ShortFlight();
  options.line_time_s = -4e-5;
  options.rate_hz = 20;
  CalibrationFlight flight = DrawCalibrationFlight(options);
  flight.config.calibration = CalibrationOptions();
  flight.config.calibration.line_time_sigma_s = 5e-5;
  const auto result = Calibrate(CalibrationInputOf(flight.config), flight.measurements, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_GT(Gain(*result, CalibrationGroup::kShutter), 0);
  EXPECT_TRUE(Says(CalibrationText(*result), "rolling shutter: -"));
  const TempFolder folder;
  WriteText(folder / "calibration.yaml",
            FormatCalibrationConfig(*result, OptionsText(flight.config)));
  const auto config = LoadConfig(folder / "calibration.yaml");
  ASSERT_TRUE(config) << config.error().message;
  const double sigma = result->sigma(LayoutOf(flight.truth).line_time());
  EXPECT_NEAR(config->set_up.rig.front().line_time_s, -4e-5, 3.5 * sigma);
  EXPECT_LT(sigma, 2e-5);
  EXPECT_EQ(config->set_up.rig.front().line_time_s, result->refined.line_time_s);
}

}  // namespace
}  // namespace tagtwist::internal::calibration_extras_test
