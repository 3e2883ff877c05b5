#include "estimator/calibration/calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "estimator/calibration/solver.h"
#include "estimator/online/config_text.h"
#include "estimator/report/files/calibration_config.h"
#include "estimator/report/files/calibration_json.h"
#include "estimator/report/files/calibration_text.h"
#include "estimator/report/html/calibration_section.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/chi_square.h"
#include "frontend/io/recordings/data_source.h"
#include "residuals/lens.h"
#include "tests/support/flights/calibration_flight.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::calibration_test {
namespace {

TEST(SlowCalibration, RecoversEverythingAtOnceWithinItsSigmas) {
  CalibrationFlightOptions options = ShortFlight();
  options.tag_bend_sigma = kBendSigma;
  const CalibrationFlight flight = DrawCalibrationFlight(options);
  const auto result =
      Calibrate(CalibrationInputOf(flight.config), flight.measurements, flight.ground_truth);
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
    options.random_seed = seed;
    const CalibrationFlight flight = DrawCalibrationFlight(options);
    const auto problem = MakeCalibrationProblem(CalibrationInputOf(flight.config),
                                                flight.measurements, flight.ground_truth);
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
  const auto result =
      Calibrate(CalibrationInputOf(flight.config), flight.measurements, flight.ground_truth);
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
  const auto result =
      Calibrate(CalibrationInputOf(flight.config), flight.measurements, flight.ground_truth);
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_TRUE(result->validation.applied().empty());
  EXPECT_EQ(result->change.norm(), 0);
  EXPECT_EQ(result->refined.camera.fx, flight.config.set_up.rig.front().camera.fx);
  EXPECT_TRUE(Says(CalibrationText(*result), "tag poses and print scale: not applied"));
}

TEST(Calibration, WithoutTruthTheMapsShapeAndTheLensAreFound) {
  const CalibrationFlight flight = DrawCalibrationFlight(ShortFlight());
  const auto result = Calibrate(CalibrationInputOf(flight.config), flight.measurements, {});
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

TEST(SlowCalibration, ConfigurationReadsBack) {
  CalibrationFlight flight = DrawCalibrationFlight(ShortFlight());
  flight.config.estimator.window_frames = 17;
  flight.config.estimator.corner_sigma_px = 0.15;
  const auto result =
      Calibrate(CalibrationInputOf(flight.config), flight.measurements, flight.ground_truth);
  ASSERT_TRUE(result) << result.error().message;
  const TempFolder folder;
  WriteText(folder / "calibration.yaml",
            FormatCalibrationConfig(*result, OptionsText(flight.config)));
  const auto config = LoadConfig(folder / "calibration.yaml");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(
      LensDifference(config->set_up.rig.front().camera, result->set_up.rig.front().camera).norm(),
      0);
  EXPECT_NE(config->set_up.rig.front().camera.fx, flight.config.set_up.rig.front().camera.fx);
  EXPECT_EQ(config->set_up.rig.front().cam_from_body.params,
            result->set_up.rig.front().cam_from_body.params);
  ASSERT_EQ(config->set_up.map.tags().size(), result->set_up.map.tags().size());
  for (size_t i = 0; i < config->set_up.map.tags().size(); ++i) {
    const Tag &read = config->set_up.map.tags()[i], &written = result->set_up.map.tags()[i];
    EXPECT_EQ(read.id, written.id);
    EXPECT_EQ(read.size_m, written.size_m);
    EXPECT_LT((read.world_from_tag.params - written.world_from_tag.params).norm(), 1e-15);
  }
  const Eigen::MatrixXd& read = config->set_up.rig.front().covariance;
  const Eigen::MatrixXd& known = result->set_up.rig.front().covariance;
  ASSERT_EQ(read.rows(), known.rows());
  EXPECT_NEAR(std::sqrt(known(kLogFocal, kLogFocal)), result->sigma(kLogFocal), 1e-12);
  const int mount = LayoutOf(result->given).mount();
  EXPECT_NEAR(known(known.rows() - 6, known.rows() - 6), result->covariance(mount, mount), 1e-15);
  const Eigen::VectorXd sigmas = known.diagonal().cwiseSqrt();
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const Eigen::Index row = i / known.rows(), column = i % known.rows();
    EXPECT_NEAR(read(row, column), known(row, column), 1e-8 * sigmas(row) * sigmas(column));
  }
  EXPECT_NE(known(kCentreX, known.rows() - 6), 0);  // centre and mount go together
  EXPECT_DOUBLE_EQ(config->estimator.tag_sigma_m.value_or(0), TagSigmaOf(*result).value_or(1));
  EXPECT_EQ(config->estimator.window_frames, 17);
  EXPECT_EQ(config->estimator.corner_sigma_px, 0.15);
  EXPECT_FALSE(config->estimator.accel_psd);
}

TEST(SlowCalibration, SummaryAndReportTellIt) {
  const CalibrationFlight flight = DrawCalibrationFlight(ShortFlight());
  const auto result =
      Calibrate(CalibrationInputOf(flight.config), flight.measurements, flight.ground_truth);
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
  const auto result = Calibrate(CalibrationInputOf(flight.config), flight.measurements, {});
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
  const auto result = Calibrate(CalibrationInputOf(*config), measurements, {});
  ASSERT_TRUE(result) << result.error().message;
  const CalibrationValidation& validation = result->validation;
  RecordProperty("given_sigma_px", std::to_string(validation.given.corner_sigma_px));
  RecordProperty("refined_sigma_px", std::to_string(validation.refined.corner_sigma_px));
  EXPECT_GT(validation.given.corner_sigma_px, 0.35);
  EXPECT_LT(validation.refined.corner_sigma_px, 0.16);
  EXPECT_TRUE(Says(CalibrationText(*result), "correlation"));
}

}  // namespace
}  // namespace tagtwist::internal::calibration_test
