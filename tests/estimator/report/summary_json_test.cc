#include "estimator/report/files/summary_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "estimator/report/findings/comparison_table.h"
#include "tests/support/flights/synthetic_estimate.h"

namespace tagtwist::internal::summary_json_test {
namespace {

using ::testing::ElementsAre;

constexpr size_t kFrames = 90;

std::vector<ComparisonRow> Rows(const Estimate& estimate, bool truth = true) {
  return CompareMethods(estimate, truth ? SmoothTruth(5, 100) : std::vector<TruthSample>(), {});
}

std::vector<std::string> Keys(const nlohmann::ordered_json& object) {
  std::vector<std::string> out;
  for (const auto& item : object.items()) out.push_back(item.key());
  return out;
}

TEST(Summary, HasTheDesignedKeys) {
  const Estimate estimate = SyntheticEstimate(kFrames, false);
  const auto s = SummaryJson(estimate, Rows(estimate), SyntheticFacts("x", kFrames));
  EXPECT_THAT(Keys(s), ElementsAre("mode", "frames", "frames_estimated", "reprojection_px", "noise",
                                   "systematic", "timing_ms", "wall_s", "peak_rss_mib", "bound",
                                   "accuracy", "dataset", "inputs", "taken", "configuration",
                                   "status", "warnings", "version"));
  EXPECT_THAT(Keys(s["reprojection_px"]), ElementsAre("median", "p95"));
  EXPECT_THAT(Keys(s["noise"]),
              ElementsAre("corner_sigma_px", "track_sigma_px", "accel_psd", "angular_accel_psd",
                          "source", "linear_prior", "angular_prior", "jerk_psd", "angular_jerk_psd",
                          "shake_s", "angular_shake_s"));
  EXPECT_THAT(
      Keys(s["systematic"]),
      ElementsAre("field_sigma_px", "tag_sigma_m", "bias_sigma_px", "position_sigma_m",
                  "rotation_sigma_rad", "common_position_sigma_m", "common_rotation_sigma_rad"));
  EXPECT_THAT(Keys(s["timing_ms"]), ElementsAre("detect", "track", "seed", "optimise", "frame"));
  EXPECT_THAT(Keys(s["timing_ms"]["frame"]), ElementsAre("p50", "p99", "max"));
  EXPECT_THAT(Keys(s["accuracy"]), ElementsAre("closed_form", "optimised"));
  const auto optimised = Keys(s["accuracy"]["optimised"]);
  EXPECT_THAT(std::vector<std::string>(optimised.begin(), optimised.begin() + 5),
              ElementsAre("position_rmse_m", "rotation_rmse_rad", "velocity_rmse_mps",
                          "rate_rmse_radps", "nees_mean"));
  EXPECT_FALSE(s["accuracy"]["closed_form"].contains("nees_mean"));
  EXPECT_EQ(s["frames"], kFrames);
  EXPECT_EQ(s["timing_ms"]["optimise"]["max"], 123.0);
  EXPECT_NEAR(s["accuracy"]["optimised"]["nees_mean"], 12, 2);
  EXPECT_NEAR(s["accuracy"]["optimised"]["nees"]["per_dof"], 1, 0.2);
}

TEST(Summary, BoundIsThatOfTheCovarianceAndTheErrorsReachIt) {
  Estimate estimate = SyntheticEstimate(kFrames, false);
  estimate.frames[3].pose_bound = 4e-6 * PoseCovariance::Identity();
  const auto bound = SummaryJson(estimate, Rows(estimate), {})["bound"];
  EXPECT_THAT(Keys(bound), ElementsAre("frame", "smoothed", "rmse_over_bound"));
  EXPECT_EQ(bound["frame"]["frames"], 1);
  EXPECT_NEAR(bound["frame"]["position_m"], std::sqrt(3 * 4e-6), 1e-12);
  EXPECT_EQ(bound["smoothed"]["frames"], kFrames);
  for (const char* part : {"position", "rotation", "velocity", "rate"}) {
    EXPECT_NEAR(bound["rmse_over_bound"][part], 1, 0.15) << part;  // errors drawn from it
  }
  const auto nothing = SummaryJson(Estimate(), {}, {})["bound"];
  EXPECT_TRUE(nothing["frame"]["position_m"].is_null());
  EXPECT_FALSE(nothing.contains("rmse_over_bound"));
}

TEST(Summary, WithoutTruthThereIsNoAccuracy) {
  const Estimate estimate = SyntheticEstimate(kFrames, true);
  const auto s = SummaryJson(estimate, CompareMethods(estimate, {}, {}), {});
  EXPECT_FALSE(s.contains("accuracy"));
  EXPECT_EQ(s["frames_estimated"], kFrames - 2);
}

TEST(Summary, TruthOfPosesLeavesVelocityAndRateOut) {
  const Estimate estimate = SyntheticEstimate(kFrames, true);
  auto truth = SmoothTruth(5, 100);
  for (TruthSample& s : truth) s.twist.reset();
  const auto s = SummaryJson(estimate, CompareMethods(estimate, truth, {}), {});
  EXPECT_THAT(Keys(s["accuracy"]), ElementsAre("closed_form", "optimised", "optimised_lagged"));
  for (const auto& a : s["accuracy"]) {
    EXPECT_TRUE(a.contains("position_rmse_m"));
    EXPECT_FALSE(a.contains("velocity_rmse_mps") || a.contains("rate_rmse_radps") ||
                 a.contains("nees_mean"));
  }
}

TEST(Summary, NothingMeasuredIsNull) {
  const auto s = SummaryJson(Estimate(), {}, {});
  EXPECT_TRUE(s["reprojection_px"]["median"].is_null());
  EXPECT_TRUE(s["timing_ms"]["detect"]["p99"].is_null());
  const auto p = PercentilesJson({5, 1, 4, 2, 3});
  EXPECT_EQ(p["p50"], 3.0);
  EXPECT_EQ(p["p99"], 5.0);
}

TEST(ComparisonTable, IsAlignedAndFitsATerminal) {
  const Estimate estimate = SyntheticEstimate(kFrames, true);
  for (const bool truth : {true, false}) {
    std::istringstream lines(FormatComparisonTable(Rows(estimate, truth)));
    std::string line;
    size_t rows = 0, width = 0;
    while (std::getline(lines, line)) {
      EXPECT_LE(line.size(), 100u) << line;
      if (rows == 0) width = line.size();
      if (rows >= 2 && rows < 7) {
        EXPECT_EQ(line.size(), width) << line;
      }
      ++rows;
    }
    EXPECT_EQ(rows, 8u);
  }
}

TEST(ComparisonTable, SaysNothingWhereThereIsNothing) {
  ComparisonRow row;
  row.name = std::string(80, 'x');
  row.accuracy = Accuracy();
  const std::string table = FormatComparisonTable({row});
  EXPECT_NE(table.find("n/a"), std::string::npos);
  EXPECT_LE(table.find('\n'), 100u);
  EXPECT_EQ(FormatComparisonTable({}), "");
}

TEST(Summary, TextOfNamesThatAreNotUtf8IsStillJson) {
  const auto s = SummaryJson(Estimate(), {}, {"flight\xff", 0, 0});
  EXPECT_EQ(nlohmann::json::parse(FormatJson(s))["frames"], 0);
}

}  // namespace
}  // namespace tagtwist::internal::summary_json_test
