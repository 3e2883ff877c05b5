// Disks that fail, memory that ends, processes that are killed: at each moment of a run the results
// are the old ones or the new ones, and nothing that is missing is passed over in silence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::fault_test {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;
using Tree = std::map<std::string, std::string>;  // name, content
constexpr int kMostRenames = 60;                  // of a run: fewer are made

// Two runs differ in their times; those pages are told apart by their being there.
Tree Results(const fs::path& folder) {
  Tree out;
  for (const std::string& name : ListTree(folder)) {
    const bool timed = name == "summary.json" || name == "report.html";
    out[name] = timed || fs::is_directory(folder / name) ? "" : ReadText(folder / name);
  }
  return out;
}

class Faults : public testing::Test {
 protected:
  void SetUp() override {
    MakeRecording(folder_.path(), "rec", DatasetFormat::kFolder, /*images=*/false);
    WriteText(folder_ / "o.tum", "0 1 1 1 0 0 0 1\n1 2 1 1 0 0 0 1\n2 3 1 1 0 0 0 1\n");
    // The older run has files that the newer one lacks, and the other way round.
    ASSERT_EQ(Estimate("old", {"--max_frames", "4", "--write_covariance"}).status, 0);
    ASSERT_EQ(Estimate("new", {}).status, 0);
    old_ = Results(folder_ / "old");
    new_ = Results(folder_ / "new");
    ASSERT_NE(old_, new_);
  }
  ProgramRun Run(const std::string& program, const Arguments& arguments, const std::string& fault) {
    Surroundings around;
    if (!fault.empty()) {
      around.environment = {"LD_PRELOAD=" TAGTWIST_FAULT_LIBRARY, "TAGTWIST_FAULT=" + fault};
    }
    return RunProgram(folder_.path(), program, arguments, {}, around);
  }
  ProgramRun Estimate(const std::string& output, const Arguments& more,
                      const std::string& fault = "") {
    Arguments arguments = {"--dataset", "rec", "--use_detections", "--threads", "1",
                           "--output",  output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run("tagtwist_estimate", arguments, fault);
  }
  void RestoreOld() {
    fs::remove_all(folder_ / "out");
    fs::copy(folder_ / "old", folder_ / "out");
  }

  TempFolder folder_;
  Tree old_, new_;
};

TEST_F(Faults, AKillAtAnyRenameLeavesOneSet) {
  int olds = 0, news = 0;
  for (int n = 1; n <= kMostRenames; ++n) {
    RestoreOld();
    const ProgramRun run = Estimate("out", {}, "rename:" + std::to_string(n) + ":kill");
    if (run.status == 0) break;
    ASSERT_EQ(run.status, -1) << run.err;
    // Whatever the next run is there for, it begins with what was left.
    const ProgramRun next =
        Run("tagtwist_estimate", {"--dataset", "absent", "--output", "out"}, "");
    EXPECT_EQ(next.status, 1);
    EXPECT_THAT(next.err, testing::HasSubstr("ended")) << "told";
    const Tree results = Results(folder_ / "out");
    EXPECT_TRUE(results == old_ || results == new_) << n;
    ++(results == old_ ? olds : news);
  }
  EXPECT_GE(olds, 5);
  EXPECT_GE(news, 5);
}

TEST_F(Faults, MemoryThatEndsAfterAnyRenameLeavesOneSet) {
  int told = 0;
  for (int n = 1; n <= kMostRenames; ++n) {
    RestoreOld();
    const ProgramRun run = Estimate("out", {}, "rename:" + std::to_string(n) + ":malloc");
    const Tree results = Results(folder_ / "out");
    EXPECT_TRUE(results == new_ || (run.status == 1 && results == old_)) << n << run.err;
    told += run.status == 1 ? 1 : 0;
  }
  EXPECT_GE(told, 5);
}

TEST_F(Faults, OtherProgramsLeaveNothingHalfWritten) {
  const std::string map = std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml";
  const Arguments simulate = {"--output", "out", "--images=false", "--duration", "1"};
  const std::vector<std::pair<std::string, Arguments>> runs = {
      {"tagtwist_simulate", simulate},
      {"tagtwist_map", {"--map", map, "--render", "out"}},
      {"tagtwist_compare", {"o.tum", "--ground_truth", "o.tum", "--json", "out"}}};
  for (const auto& [program, arguments] : runs) {
    for (const std::string kind : {"write", "rename"}) {
      for (int n = 1; n <= 8; ++n) {
        fs::remove_all(folder_ / "out");
        const auto before = ListTree(folder_.path());
        const ProgramRun run = Run(program, arguments, kind + ":" + std::to_string(n));
        if (run.status == 0) {
          EXPECT_TRUE(fs::exists(folder_ / "out"));
          if (n > 1) break;
          continue;
        }
        EXPECT_EQ(run.status, 1);
        EXPECT_TRUE(IsOneLine(run.err)) << run.err;
        EXPECT_EQ(ListTree(folder_.path()), before) << program << " " << kind << " " << n;
      }
    }
  }
}

TEST_F(Faults, MemoryThatEndsAnywhereIsOneLine) {
  const Arguments compare = {"o.tum", "--ground_truth", "o.tum", "--json", "out"};
  ASSERT_EQ(Run("tagtwist_compare", compare, "").status, 0);
  const std::string whole = ReadText(std::string(folder_ / "out"));
  int told = 0;
  for (int n = 1; n <= 600; n += 7) {
    fs::remove(folder_ / "out");
    const ProgramRun run = Run("tagtwist_compare", compare, "malloc:" + std::to_string(n));
    if (run.status == 0) continue;
    EXPECT_EQ(run.status, 1) << n << run.err;
    EXPECT_TRUE(IsOneLine(run.err)) << n << run.err;
    if (fs::exists(folder_ / "out")) {
      EXPECT_EQ(ReadText(std::string(folder_ / "out")), whole) << n;
    }
    ++told;
  }
  EXPECT_GE(told, 40);
}

}  // namespace
}  // namespace tagtwist::internal::fault_test
