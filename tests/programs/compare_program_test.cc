// tagtwist_compare, as it is run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/report/result_writer.h"
#include "tests/support/flights/synthetic_estimate.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::compare_program_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

ProgramRun RunCompare(const TempFolder& folder, const std::vector<std::string>& arguments) {
  return RunProgram(folder.path(), "tagtwist_compare", arguments);
}

// Four frames 1 s apart along x, the truth straight; errors of 3, 4, 0, 0 mm in y and z.
TEST(CompareProgram, FiguresOfAHandMadeCase) {
  const TempFolder folder;
  WriteText(folder / "truth.tum",
            "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n"
            "3 3 0 0 0 0 0 1\n");
  WriteText(folder / "a.tum",
            "0 0 0.003 0 0 0 0 1\n1 1 0 0.004 0 0 0 1\n2 2 0 0 0 0 0 1\n"
            "3 3 0 0 0 0 0.01 0.99995\n");
  const ProgramRun run =
      RunCompare(folder, {"a.tum", "--ground_truth", "truth.tum", "--json", "out.json"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(run.out, HasSubstr("a.tum"));
  const auto json = nlohmann::json::parse(ReadText(folder / "out.json"));
  EXPECT_EQ(json["ground_truth"], "truth.tum");
  EXPECT_EQ(json["align"], "none");
  ASSERT_EQ(json["inputs"].size(), 1u);
  const auto& input = json["inputs"][0];
  EXPECT_EQ(input["name"], "a.tum");
  EXPECT_EQ(input["frames"], 4);
  const auto& a = input["accuracy"];
  // ATE: sqrt((9 + 16) / 4) = 2.5 mm. RPE over one frame: 5, 4, 0 mm.
  EXPECT_NEAR(a["position_rmse_m"], 0.0025, 1e-9);
  EXPECT_NEAR(a["rotation_rmse_rad"], 0.02 / 2, 1e-5);
  EXPECT_NEAR(a["rpe_frames"]["translation_rmse_m"], std::sqrt((25.0 + 16) / 3) * 1e-3, 1e-9);
  EXPECT_NEAR(a["rpe_time"]["translation_rmse_m"], std::sqrt((25.0 + 16) / 3) * 1e-3, 1e-9);
  EXPECT_NEAR(a["rpe_time"]["rotation_rmse_rad"], 0.02 / std::sqrt(3.0), 1e-5);
  EXPECT_FALSE(a.contains("velocity_rmse_mps"));
}

TEST(CompareProgram, OutputFoldersSideBySide) {
  const TempFolder folder;
  for (const bool window : {false, true}) {
    const Estimate estimate = SyntheticEstimate(120, window);
    ResultContext context;
    context.map = MakeTagMap(TagGrid());
    context.truth = SmoothTruth(5, 100);
    context.rows = CompareMethods(estimate, context.truth, {});
    context.write_covariance = true;
    ASSERT_TRUE(WriteResults(folder / (window ? "window" : "batch"), estimate, context));
  }
  const ProgramRun run =
      RunCompare(folder, {"batch/", "window", "--align", "handeye", "--html", "page.html"});
  ASSERT_EQ(run.status, 0) << run.err;
  for (const char* name : {"batch: closed form", "batch: optimised", "window: closed form",
                           "window: optimised, lag 0", "window: optimised, lagged"}) {
    EXPECT_THAT(run.out, HasSubstr(name));
  }
  EXPECT_THAT(run.out, HasSubstr("NEES/dof: 1 where the covariance is right"));
  EXPECT_THAT(run.out, HasSubstr("window: optimised, lagged: marker in the body at "));
  EXPECT_THAT(ReadText(folder / "page.html"), HasSubstr("window: optimised, lagged"));
}

TEST(CompareProgram, WithoutTruthTellsWhatCanBeTold) {
  const TempFolder folder;
  WriteText(folder / "a.tum", "0 0 0 0 0 0 0 1\n");
  const ProgramRun run = RunCompare(folder, {"a.tum"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, StartsWith("no ground truth"));
}

TEST(CompareProgram, TooFewPosesToAlignAreRefusedAndNothingIsWritten) {
  const TempFolder folder;
  WriteText(folder / "truth.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n");
  WriteText(folder / "a.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n");
  const ProgramRun run = RunCompare(
      folder, {"a.tum", "--ground_truth", "truth.tum", "--align", "se3", "--json", "out.json"});
  EXPECT_EQ(run.status, 1);
  EXPECT_EQ(run.err,
            "tagtwist_compare: a.tum: alignment needs at least 3 poses with ground truth, got 2\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "out.json"));
}

// Students' closed forms of the real trials against Vicon, no alignment: 15.1 and 17.2 mm (3-D).
TEST(RealDataCompare, FiguresOfTheCourseAsMeasuredBefore) {
  const std::string data = std::string(TAGTWIST_REAL_DATA_DIR) + "/course/";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "no " << data;
  const TempFolder folder;
  const auto rmse = [&](const std::string& trial, const std::string& align) {
    const ProgramRun run = RunCompare(
        folder, {data + "est_pose_dataset" + trial + "_baselineA.csv", "--ground_truth",
                 data + "vicon_dataset" + trial + ".csv", "--align", align, "--json", "j"});
    EXPECT_EQ(run.status, 0) << run.err;
    return nlohmann::json::parse(ReadText(folder / "j"))["inputs"][0]["accuracy"]["position_rmse_m"]
        .get<double>();
  };
  EXPECT_NEAR(rmse("1", "none"), 0.0151, 0.0001);
  EXPECT_NEAR(rmse("4", "none"), 0.0172, 0.0001);
  EXPECT_LT(rmse("1", "se3"), 0.009);  // most of it is a constant offset
  EXPECT_LT(rmse("1", "handeye"), 0.008);
}

}  // namespace
}  // namespace tagtwist::internal::compare_program_test
