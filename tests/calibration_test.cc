#include "estimator/calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "estimator/calibration_config.h"
#include "estimator/calibration_json.h"
#include "estimator/calibration_solver.h"
#include "estimator/calibration_text.h"
#include "estimator/chi_square.h"
#include "estimator/format_text.h"
#include "estimator/report_calibration.h"
#include "frontend/data_source.h"
#include "residuals/lens.h"
#include "tests/calibration_flight.h"
#include "tests/test_files.h"

namespace tagtwist {
namespace {

bool Says(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

double Gain(const Calibration& calibration, CalibrationGroup group) {
  for (const GroupVerdict& verdict : calibration.validation.verdicts) {
    if (verdict.group == group) return verdict.applied ? verdict.gain : 0;
  }
  return 0;
}

constexpr double kBendSigma = 0.007;  // in sides, 1.06 mm

// Few frames and tags: every calibration is twenty and more searches.
CalibrationFlightOptions ShortFlight() {
  CalibrationFlightOptions options;
  options.rows = 4;
  options.columns = 4;
  options.frames = 80;
  options.rate_hz = 7;  // between the samples of the ground truth, not on them
  return options;
}

TEST(SlowCalibration, RecoversEverythingAtOnceWithinItsSigmas) {
  CalibrationFlightOptions options = ShortFlight();
  options.tag_bend_sigma = kBendSigma;
  const CalibrationFlight flight = DrawCalibrationFlight(options);
  const auto result = Calibrate(flight.config, flight.measurements, flight.ground_truth);
  ASSERT_TRUE(result) << result.error().message;
  for (const CalibrationGroup group : kAllCalibrationGroups) {
    if (group == CalibrationGroup::kShutter) continue;  // held
    EXPECT_GT(Gain(*result, group), 0) << ToString(group);
  }
  const Eigen::VectorXd error = Difference(result->refined, flight.truth);
  const CalibrationLayout layout = LayoutOf(flight.truth);
  for (int i = 0; i < layout.tag(0); ++i) {
    if (!(result->prior_sigmas(i) > 0)) continue;
    const std::string& name = result->parameters[static_cast<size_t>(i)].name;
    EXPECT_LT(std::abs(error(i)), 3.5 * result->sigma(i)) << name;
  }
  EXPECT_LT(result->sigma(kLogFocal), 0.001);
  EXPECT_LT(result->sigma(layout.clock()), 0.0005);
  EXPECT_NEAR(result->noise.corner_sigma_px, 0.15, 0.01);
  EXPECT_NEAR(result->noise.truth_position_sigma_m, 0.0005, 0.0001);
  EXPECT_NEAR(result->noise.truth_rotation_sigma_rad, 0.001, 0.0002);
}

TEST(SlowCalibration, ErrorsOverCovarianceAreChiSquare) {
  double nees = 0;
  int dof = 0;
  for (const unsigned seed : {2U, 3U, 4U}) {
    CalibrationFlightOptions options = ShortFlight();
    options.seed = seed;
    const CalibrationFlight flight = DrawCalibrationFlight(options);
    const auto problem =
        MakeCalibrationProblem(flight.config, flight.measurements, flight.ground_truth);
    ASSERT_TRUE(problem) << problem.error().message;
    const CalibrationSolution solution =
        SolveAndLearnNoise(*problem, problem->prior, CalibrationNoise(), true);
    ASSERT_TRUE(solution.usable);
    std::vector<int> free;
    for (Eigen::Index i = 0; i < problem->prior_sigmas.size(); ++i) {
      if (problem->prior_sigmas(i) > 0) free.push_back(static_cast<int>(i));
    }
    const Eigen::VectorXd error = Difference(solution.state, flight.truth)(free);
    const Eigen::MatrixXd covariance = solution.covariance(free, free);
    nees += error.dot(covariance.ldlt().solve(error));
    dof += static_cast<int>(free.size());
  }
  const auto [low, high] = MeanChiSquareBand(dof, 1);
  EXPECT_GT(nees, low);
  EXPECT_LT(nees, high);
}

// What a motion does not show is named, moves by no more than its prior, and is as uncertain as it
// is wrong.
class SlowCalibrationOfPoorMotion : public testing::TestWithParam<CalibrationMotion> {};
INSTANTIATE_TEST_SUITE_P(Motions, SlowCalibrationOfPoorMotion,
                         testing::Values(CalibrationMotion::kNoRotation,
                                         CalibrationMotion::kConstantHeight));

TEST_P(SlowCalibrationOfPoorMotion, NamesWhatItDoesNotShowAndNothingRunsAway) {
  CalibrationFlightOptions options = ShortFlight();
  options.motion = GetParam();
  options.rows = 6;  // of a small map tilts pass for shifts
  options.columns = 6;
  const CalibrationFlight flight = DrawCalibrationFlight(options);
  const auto result = Calibrate(flight.config, flight.measurements, flight.ground_truth);
  ASSERT_TRUE(result) << result.error().message;
  const std::vector<std::string> text = CalibrationText(*result);
  EXPECT_TRUE(Says(text, "does not show mount z with world z"));
  if (GetParam() == CalibrationMotion::kNoRotation) {
    EXPECT_TRUE(Says(text, "does not show mount x with world"));
    EXPECT_TRUE(Says(text, "does not show mount y with world"));
  } else {
    EXPECT_TRUE(Says(text, "does not show focal length with"));
  }
  const Eigen::VectorXd error = Difference(result->refined, flight.truth);
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    const double prior_sigma = result->prior_sigmas(i);
    if (!(prior_sigma > 0)) continue;
    const std::string& name = result->parameters[static_cast<size_t>(i)].name;
    EXPECT_LT(std::abs(error(i)), 4.5 * result->sigma(static_cast<int>(i))) << name;
    EXPECT_LT(std::abs(result->change(i)), 4 * prior_sigma) << name;
    EXPECT_LT(result->sigma(static_cast<int>(i)), 1.001 * prior_sigma) << name;
  }
}

TEST(SlowCalibration, WhatDoesNotHelpUnseenFramesIsNotApplied) {
  CalibrationFlightOptions options = ShortFlight();
  options.errors = false;
  options.tag_position_sigma_m = 0;
  options.tag_rotation_sigma_rad = 0;
  CalibrationFlight flight = DrawCalibrationFlight(options);
  flight.config.calibration = CalibrationOptions();
  const auto result = Calibrate(flight.config, flight.measurements, flight.ground_truth);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_TRUE(result->validation.applied().empty());
  EXPECT_EQ(result->change.norm(), 0);
  EXPECT_EQ(result->refined.camera.fx, flight.config.camera.fx);
  EXPECT_TRUE(Says(CalibrationText(*result), "tag poses and print scale: not applied"));
}

TEST(Calibration, WithoutTruthTheMapsShapeAndTheLensAreFound) {
  const CalibrationFlight flight = DrawCalibrationFlight(ShortFlight());
  const auto result = Calibrate(flight.config, flight.measurements, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_NEAR(result->change(kLogFocal), 0.01, 3.5 * result->sigma(kLogFocal));
  const CalibrationLayout layout = LayoutOf(flight.truth);
  EXPECT_EQ(result->change.segment(layout.scale(), 15).norm(), 0);  // all but tags and lens
  ASSERT_GE(result->unseen.size(), 6u);
  for (size_t i = 0; i < 6; ++i) {
    const UnseenDirection& direction = result->unseen[i];
    ASSERT_FALSE(direction.parts.empty());
    EXPECT_EQ(direction.parts[0].kind, "the map as a whole");
    EXPECT_GT(direction.parts[0].share, 0.9);
  }
  const std::vector<std::string> text = CalibrationText(*result);
  EXPECT_TRUE(Says(text, "the configured K belongs to another camera"));
  EXPECT_TRUE(Says(text, "above where the map has it"));
  EXPECT_LT(result->validation.refined.corner_sigma_px, 0.16);
  EXPECT_GT(result->validation.given.corner_sigma_px, 0.4);
}

// Images alone, everything else free; 10 flights.
TEST(SlowCalibration, BendsOfTheTagsAreChiSquare) {
  constexpr int kFlights = 10;
  double bends_nees = 0, nees = 0;
  int bends = 0, within = 0, dof = 0;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    CalibrationFlightOptions options = ShortFlight();
    options.tag_bend_sigma = kBendSigma;
    options.seed = seed;
    const CalibrationFlight flight = DrawCalibrationFlight(options);
    const auto problem = MakeCalibrationProblem(flight.config, flight.measurements, {});
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
  const auto result = Calibrate(flight.config, flight.measurements, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_GT(Gain(*result, CalibrationGroup::kBend), 0);
  EXPECT_TRUE(Says(CalibrationText(*result), "tags are bent by "));
  EXPECT_TRUE(Says(CalibrationText(*result), " is bent by "));
  const std::vector<TagBend> bends = TagBends(*result);
  ASSERT_EQ(bends.size(), 16u);
  EXPECT_EQ(CalibrationJson(*result)["bends"][3]["bend_m"], bends[3].bend_m);
  const TempFolder folder;
  WriteText(folder / "calibration.yaml", FormatCalibrationConfig(*result));
  const auto config = LoadConfig(folder / "calibration.yaml");
  ASSERT_TRUE(config) << config.error().message;
  for (size_t i = 0; i < bends.size(); ++i) {
    EXPECT_NEAR(bends[i].bend_m, flight.truth.tags[i].bend_m, 4 * bends[i].sigma_m);
    const int id = bends[i].id;
    for (size_t c = 0; c < 4; ++c) {
      const Eigen::Vector3d &read = config->map.CornersInWorld(id)[c],
                            &written = result->config.map.CornersInWorld(id)[c];
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
  const Config applied = Apply(flight.config, state);
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
  const auto result = Calibrate(config, flight.measurements, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_GT(Gain(*result, CalibrationGroup::kMap), 0);
  EXPECT_TRUE(Says(CalibrationText(*result), "bends of the tags: not applied"));
  EXPECT_TRUE(TagBends(*result).empty());
  const CalibrationLayout layout = LayoutOf(flight.truth);
  for (int i = 0; i < layout.n_tags; ++i) {
    EXPECT_EQ(result->config.map.tags()[static_cast<size_t>(i)].bend_m, 0);
    EXPECT_EQ(result->sigma(layout.bend(i)), result->prior_sigmas(layout.bend(i)));
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
    options.seed = seed;
    CalibrationFlight flight = DrawCalibrationFlight(options);
    flight.config.calibration.line_time_sigma_s = 5e-5;
    const auto problem = MakeCalibrationProblem(flight.config, flight.measurements, {});
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
  const auto result = Calibrate(flight.config, flight.measurements, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_GT(Gain(*result, CalibrationGroup::kShutter), 0);
  EXPECT_TRUE(Says(CalibrationText(*result), "rolling shutter: -"));
  const TempFolder folder;
  WriteText(folder / "calibration.yaml", FormatCalibrationConfig(*result));
  const auto config = LoadConfig(folder / "calibration.yaml");
  ASSERT_TRUE(config) << config.error().message;
  const double sigma = result->sigma(LayoutOf(flight.truth).line_time());
  EXPECT_NEAR(config->line_time_s, -4e-5, 3.5 * sigma);
  EXPECT_LT(sigma, 2e-5);
  EXPECT_EQ(config->line_time_s, result->refined.line_time_s);
}

TEST(SlowCalibration, ConfigurationReadsBack) {
  CalibrationFlight flight = DrawCalibrationFlight(ShortFlight());
  flight.config.estimator.window_frames = 17;
  flight.config.estimator.corner_sigma_px = 0.15;
  const auto result = Calibrate(flight.config, flight.measurements, flight.ground_truth);
  ASSERT_TRUE(result) << result.error().message;
  const TempFolder folder;
  WriteText(folder / "calibration.yaml", FormatCalibrationConfig(*result));
  const auto config = LoadConfig(folder / "calibration.yaml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(LensDifference(config->camera, result->config.camera).norm(), 0);
  EXPECT_NE(config->camera.fx, flight.config.camera.fx);
  EXPECT_EQ(config->cam_from_body.params, result->config.cam_from_body.params);
  ASSERT_EQ(config->map.tags().size(), result->config.map.tags().size());
  for (size_t i = 0; i < config->map.tags().size(); ++i) {
    const Tag &read = config->map.tags()[i], &written = result->config.map.tags()[i];
    EXPECT_EQ(read.id, written.id);
    EXPECT_EQ(read.size_m, written.size_m);
    EXPECT_LT((read.world_from_tag.params - written.world_from_tag.params).norm(), 1e-15);
  }
  EXPECT_EQ(config->estimator.window_frames, 17);
  EXPECT_EQ(config->estimator.corner_sigma_px, 0.15);
  EXPECT_FALSE(config->estimator.accel_psd);
}

TEST(SlowCalibration, SummaryAndReportTellIt) {
  const CalibrationFlight flight = DrawCalibrationFlight(ShortFlight());
  const auto result = Calibrate(flight.config, flight.measurements, flight.ground_truth);
  ASSERT_TRUE(result) << result.error().message;
  const nlohmann::ordered_json json = CalibrationJson(*result);
  const auto& focal = json["parameters"]["focal length"];
  EXPECT_EQ(focal["change"], result->change(kLogFocal));
  EXPECT_EQ(focal["applied"], true);
  ASSERT_EQ(json["tags"].size(), 16u);
  const double up_mm = 1e3 * json["tags"][0]["up_m"].get<double>();
  const ReportSection section = CalibrationSection(*result);
  EXPECT_NE(section.html.find(">" + Format("%+.1f", up_mm) + "</text>"), std::string::npos);
  EXPECT_NE(section.html.find("principal point"), std::string::npos);
}

TEST(Calibration, TooFewFramesAreRefused) {
  CalibrationFlight flight = DrawCalibrationFlight(ShortFlight());
  flight.measurements.resize(12);
  const auto result = Calibrate(flight.config, flight.measurements, {});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message, "a calibration needs 20 frames with tags, got 12");
}

// A hand-held camera over 81 tags whose map was measured as flat; every eighth frame.
TEST(RealDataCalibration, MapOfTheFloorMatHoldsForFramesNotFittedTo) {
  const std::filesystem::path folder =
      std::filesystem::path(TAGTWIST_REAL_DATA_DIR) / "umd-floor-mat";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no real data at " << folder;
  const auto config =
      LoadConfig(std::string(TAGTWIST_SOURCE_DIR) + "/tests/configs/umd_floor_mat.yaml");
  ASSERT_TRUE(config) << config.error().message;
  auto source = OpenDataSource(folder, {true, false, {}});
  ASSERT_TRUE(source) << source.error().message;
  std::vector<FrameMeasurements> measurements;
  for (int i = 0;; ++i) {
    auto frame = (*source)->Next();
    ASSERT_TRUE(frame) << frame.error().message;
    if (!*frame) break;
    if (i % 8 != 0) continue;
    measurements.push_back({});
    measurements.back().t_ns = (*frame)->t_ns;
    measurements.back().tags = (*frame)->detections;
  }
  const auto result = Calibrate(*config, measurements, {});
  ASSERT_TRUE(result) << result.error().message;
  const CalibrationValidation& validation = result->validation;
  RecordProperty("given_sigma_px", std::to_string(validation.given.corner_sigma_px));
  RecordProperty("refined_sigma_px", std::to_string(validation.refined.corner_sigma_px));
  EXPECT_GT(validation.given.corner_sigma_px, 0.35);
  EXPECT_LT(validation.refined.corner_sigma_px, 0.16);
  EXPECT_TRUE(Says(CalibrationText(*result), "correlation"));
}

}  // namespace
}  // namespace tagtwist
