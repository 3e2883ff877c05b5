#include "estimator/fleet/read_fleet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "estimator/fleet/figures.h"
#include "estimator/fleet/fleet_files.h"
#include "tests/support/fleets.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::read_fleet_test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr char kSummary[] = R"({"status": "done", "frames": 50, "frames_estimated": 48,
  "verdict": "Good.", "findings": [{"fact": "Few tags.", "advice": ""}], "warnings": ["w"],
  "accuracy": {"optimised": {"position_rmse_m": 0.002}}, "bound": {"smoothed": {"position_m": 0.001}},
  "wall_s": 1.5, "version": "0.1.0", "inputs": [{"flag": "--dataset", "sha256": "ab"}]})";

class ReadFleetTest : public testing::Test {
 protected:
  void Write(const std::string& path, const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(folder_ / path).parent_path());
    WriteText(folder_ / path, text);
  }
  std::string FaultOf(const std::string& path) {
    const auto fleet = ReadFleet(folder_ / path);
    return fleet ? "none" : fleet.error().message;
  }
  TempFolder folder_;
};

TEST_F(ReadFleetTest, FindsSummariesBelowAFolder) {
  Write("all/b/summary.json", kSummary);
  Write("all/a/deep/summary.json",
        R"({"status": "failed", "error": "no tags", "version": "0.1.0"})");
  const auto fleet = ReadFleet(folder_ / "all/");
  ASSERT_TRUE(fleet) << fleet.error().message;
  ASSERT_THAT(fleet->rows, SizeIs(2));
  EXPECT_EQ(fleet->rows[0].name, "a/deep");
  EXPECT_EQ(fleet->rows[0].outcome, FleetOutcome::kFailed);
  EXPECT_EQ(fleet->rows[0].error, "no tags");
  const FleetRow& done = fleet->rows[1];
  EXPECT_EQ(done.first_finding, "Few tags.");
  EXPECT_EQ(done.frames_estimated, 48);
  EXPECT_EQ(done.figures[FigureIndex("position_rmse_m")], 0.002);
  EXPECT_EQ(done.figures[FigureIndex("bound_position_m")], 0.001);
  EXPECT_TRUE(std::isnan(done.figures[FigureIndex("nees_per_dof")]));
  EXPECT_THAT(ProgramsOf(*fleet), IsEmpty());
}

TEST_F(ReadFleetTest, TakesTheRunsThatAreListed) {
  Write("f/runs/x-1/summary.json", kSummary);
  Write("f/runs/left/summary.json", kSummary);
  Write("f/runs.json", R"({"runs": [
    {"name": "x <b>", "folder": "runs/x-1", "outcome": "done", "values": {"config": "a.yaml"}},
    {"name": "y", "folder": "runs/y-2", "outcome": "failed", "error": "damaged", "log": "logs/y"}]})");
  const auto fleet = ReadFleet(folder_ / "f");
  ASSERT_TRUE(fleet) << fleet.error().message;
  ASSERT_THAT(fleet->rows, SizeIs(2));
  EXPECT_EQ(NameOf(fleet->rows[0]), "x <b> (config=a.yaml)");
  EXPECT_EQ(fleet->rows[1].error, "damaged");
  EXPECT_THAT(fleet->rows[1].log, HasSubstr("f/logs/y"));
}

TEST_F(ReadFleetTest, AFailedRunShowsNoFiguresOfAnOlderOne) {
  Write("f/runs/x-1/summary.json", kSummary);
  Write("f/runs.json",
        R"({"runs": [{"name": "x", "folder": "runs/x-1", "outcome": "failed", "error": "new"}]})");
  const auto fleet = ReadFleet(folder_ / "f");
  ASSERT_TRUE(fleet) << fleet.error().message;
  EXPECT_EQ(fleet->rows[0].error, "new");
  EXPECT_TRUE(std::isnan(fleet->rows[0].figures[0]));
}

TEST_F(ReadFleetTest, ReadsBackWhatWasWritten) {
  const Fleet fleet = DrawFleet(5, 1, 1);
  Write("fleet.json", FormatFleetJson(fleet, nullptr, nullptr));
  const auto again = ReadFleet(folder_ / "fleet.json");
  ASSERT_TRUE(again) << again.error().message;
  ASSERT_THAT(again->rows, SizeIs(5));
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(again->rows[i].figures, fleet.rows[i].figures);
    EXPECT_EQ(again->rows[i].name, fleet.rows[i].name);
    EXPECT_EQ(again->rows[i].outcome, fleet.rows[i].outcome);
  }
}

TEST_F(ReadFleetTest, NamesTheFileThatIsWrong) {
  Write("cut/a/summary.json", std::string(kSummary).substr(0, 100));
  EXPECT_THAT(FaultOf("cut"), HasSubstr("a/summary.json: expected JSON"));
  std::filesystem::create_directories(folder_ / "empty");
  EXPECT_THAT(FaultOf("empty"), HasSubstr("empty: holds no results"));
  EXPECT_THAT(FaultOf("absent"), HasSubstr("absent: "));
  Write("up/runs.json",
        R"({"runs": [{"name": "x", "folder": "../elsewhere", "outcome": "done"}]})");
  EXPECT_THAT(FaultOf("up"), HasSubstr("runs[0]: expected a name, and a folder below"));
  Write("gone/runs.json", R"({"runs": [{"name": "x", "folder": "runs/x", "outcome": "done"}]})");
  EXPECT_THAT(FaultOf("gone"), HasSubstr("runs/x/summary.json: is missing"));
  Write("odd/runs.json", R"({"runs": 3})");
  EXPECT_THAT(FaultOf("odd"), HasSubstr("runs.json: runs: expected a list"));
  Write("odd.json", R"({"rows": [1, {"recording": 2, "values": [], "frames": "x"}]})");
  EXPECT_EQ(FaultOf("odd.json"), "none");
}

TEST_F(ReadFleetTest, SeveralVersionsAreTold) {
  Fleet fleet = DrawFleet(3, 1, 1);
  EXPECT_THAT(ProgramsOf(fleet), IsEmpty());
  fleet.rows[2].program_sha256 = "0123456789";
  EXPECT_THAT(ProgramsOf(fleet), SizeIs(2));
}

}  // namespace
}  // namespace tagtwist::internal::read_fleet_test
