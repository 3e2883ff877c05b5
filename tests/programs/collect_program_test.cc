// tagtwist_compare --collect: many runs in one table.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::collect_program_test {
namespace {

using ::testing::HasSubstr;

class CollectProgram : public testing::Test {
 protected:
  void SetUp() override {
    MakeRecording(folder_.path(), "rec", DatasetFormat::kFolder, false);
    for (const char* name : {"all/one", "all/two & <three>"}) Estimate(name);
  }
  void Estimate(const std::string& output) {
    const ProgramRun run = RunProgram(folder_.path(), "tagtwist_estimate",
                                      {"--dataset", "rec", "--use_detections", "--output", output});
    ASSERT_EQ(run.status, 0) << run.err;
  }
  ProgramRun Collect(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "--collect");
    return RunProgram(folder_.path(), "tagtwist_compare", arguments);
  }
  nlohmann::json Json(const std::string& path) {
    return nlohmann::json::parse(ReadText(folder_ / path));
  }
  TempFolder folder_;
};

TEST_F(CollectProgram, GathersWhatALoopHasLeft) {
  std::filesystem::create_directories(folder_ / "all/failed");
  WriteText(folder_ / "all/failed/summary.json",
            R"({"status": "failed", "error": "no tags", "version": "0.1.0"})");
  const ProgramRun run = Collect({"all"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("failed: failed: no tags\n2 of 3 recordings done"));
  const nlohmann::json rows = Json("all/fleet.json")["rows"];
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[2]["recording"], "two & <three>");
  EXPECT_EQ(rows[1]["frames_estimated"], 6);
  EXPECT_GT(rows[1]["bound_position_m"], 0);
  EXPECT_GT(rows[1]["position_rmse_m"], 0);
  EXPECT_THAT(ReadText(folder_ / "all/fleet.html"), HasSubstr("two &amp; &lt;three&gt;"));
  EXPECT_THAT(ReadText(folder_ / "all/fleet.csv"), HasSubstr("\none,,done,"));
  // The table is none of the results that it gathers.
  const ProgramRun again = Collect({"all", "--against", "all"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("against all: no difference"));
}

TEST_F(CollectProgram, SummariesSayWhatTheRunWasMadeWith) {
  const nlohmann::json summary = Json("all/one/summary.json");
  EXPECT_THAT(summary["configuration"], HasSubstr("\ncamera:\n  width: 376\n"));
  EXPECT_THAT(summary["configuration"], HasSubstr("\nestimator:\n"));
  EXPECT_THAT(summary["configuration"], HasSubstr("# tag_map: 108 tags of tag36h11, SHA-256 "));
  EXPECT_TRUE(summary["findings"].is_array());
}

// What it says is a configuration that can be read again.
TEST_F(CollectProgram, TheConfigurationAsResolvedReadsBack) {
  WriteText(folder_ / "again.yaml", Json("all/one/summary.json")["configuration"]);
  const ProgramRun run = RunProgram(
      folder_.path(), "tagtwist_estimate",
      {"--dataset", "rec", "--use_detections", "--output", "again", "--config", "again.yaml"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(ReadText(folder_ / "again/states.csv"), ReadText(folder_ / "all/one/states.csv"));
}

TEST_F(CollectProgram, VersionsAreNotMixedSilently) {
  nlohmann::json summary = Json("all/one/summary.json");
  summary["version"] = "0.0.9";
  WriteText(folder_ / "all/one/summary.json", summary.dump());
  const ProgramRun run = Collect({"all"});
  EXPECT_EQ(run.status, 1);
  EXPECT_TRUE(IsOneLine(run.err));
  EXPECT_THAT(run.err, HasSubstr("all: results of several versions: 'one' by version 0.0.9, "));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "all/fleet.html"));
  EXPECT_EQ(Collect({"all", "--mix_versions"}).status, 0);
}

TEST_F(CollectProgram, InputsAreKept) {
  ASSERT_EQ(Collect({"all", "--output", "table"}).status, 0);
  const std::string before = ReadText(folder_ / "table/fleet.json");
  const ProgramRun run = Collect({"all", "--output", "table", "--against", "table/fleet.json"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("table/fleet.json: --output would overwrite it"));
  EXPECT_EQ(ReadText(folder_ / "table/fleet.json"), before);
}

TEST_F(CollectProgram, WrongUseAndNothingToCollect) {
  const ProgramRun without =
      RunProgram(folder_.path(), "tagtwist_compare", {"all/one", "--against", "all"});
  EXPECT_EQ(without.status, 2);
  EXPECT_THAT(without.err, HasSubstr("expected with --collect"));
  const ProgramRun nothing = Collect({"rec"});
  EXPECT_EQ(nothing.status, 1);
  EXPECT_THAT(nothing.err, HasSubstr("rec: holds no results of tagtwist_estimate"));
}

}  // namespace
}  // namespace tagtwist::internal::collect_program_test
