#include "frontend/base/files/run_files.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/test_files.h"

namespace tagtwist::internal::run_files_test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(RunFiles, AnOutputThatIsReadIsRefused) {
  const TempFolder temp;
  WriteText(temp / "truth.tum", "1");
  RunFiles files;
  files.Reads("--ground_truth", temp / "truth.tum");
  files.Reads("--map", "");
  EXPECT_TRUE(files.Writes("--json", temp / "new.json"));
  EXPECT_TRUE(files.Writes("--html", ""));
  const auto clash = files.Writes("--stream", temp.path() + "/./truth.tum");
  ASSERT_FALSE(clash);
  EXPECT_THAT(clash.error().message, HasSubstr("--stream would overwrite it"));
  EXPECT_THAT(clash.error().message, HasSubstr("--ground_truth " + (temp / "truth.tum")));
}

TEST(RunFiles, ALinkIsTheFileThatItLeadsTo) {
  const TempFolder temp;
  WriteText(temp / "truth.tum", "1");
  fs::create_symlink("truth.tum", temp / "soft");
  fs::create_hard_link(temp / "truth.tum", temp / "hard");
  RunFiles files;
  files.Reads("--ground_truth", temp / "soft");
  EXPECT_FALSE(files.Writes("--stream", temp / "truth.tum"));
  EXPECT_FALSE(files.Writes("--stream", temp / "soft"));
  EXPECT_FALSE(files.Writes("--stream", temp / "hard"));
}

TEST(RunFiles, AllThatARecordingHoldsIsRead) {
  const TempFolder temp;
  fs::create_directories(temp / "rec/cam0/data");
  WriteText(temp / "rec/cam0/data/1.png", "1");
  WriteText(temp / "elsewhere.png", "2");
  fs::create_symlink("../../../elsewhere.png", temp / "rec/cam0/data/2.png");
  fs::create_directory_symlink("../..", temp / "rec/cam0/circle");
  RunFiles files;
  files.ReadsRecording("--dataset", temp / "rec");
  EXPECT_FALSE(files.Writes("--stream", temp / "rec/cam0/data/1.png"));
  EXPECT_FALSE(files.Writes("--stream", temp / "elsewhere.png"));
  EXPECT_TRUE(files.Writes("--stream", temp / "rec/rows.csv")) << "a new file overwrites none";
}

TEST(RunFiles, DevicesAndPipesMayBeBoth) {
  const TempFolder temp;
  ASSERT_EQ(::mkfifo((temp / "fifo").c_str(), 0600), 0);
  RunFiles files;
  files.Reads("--map", temp / "fifo");
  files.Reads("--config", "/dev/null");
  EXPECT_TRUE(files.Writes("--stream", temp / "fifo"));
  EXPECT_TRUE(files.Writes("--json", "/dev/null"));
  EXPECT_TRUE(files.Writes("--html", "/dev/null"));
}

TEST(RunFiles, StandardOutputIntoAFileThatIsReadIsRefused) {
  const TempFolder temp;
  WriteText(temp / "truth.tum", "1");
  RunFiles files;
  files.Reads("--ground_truth", temp / "truth.tum");
  const int terminal = ::dup(STDOUT_FILENO);
  const int truth = ::open((temp / "truth.tum").c_str(), O_WRONLY | O_APPEND);
  ::dup2(truth, STDOUT_FILENO);
  const auto clash = files.WritesStandardOutput();
  const auto other = RunFiles().WritesStandardOutput();
  ::dup2(terminal, STDOUT_FILENO);
  ::close(truth);
  ::close(terminal);
  EXPECT_FALSE(clash);
  EXPECT_TRUE(other);
}

TEST(RunFiles, TwoOutputsAreTwoFiles) {
  const TempFolder temp;
  RunFiles files;
  ASSERT_TRUE(files.Writes("--json", temp / "figures"));
  const auto clash = files.Writes("--html", temp.path() + "/./figures");
  ASSERT_FALSE(clash);
  EXPECT_THAT(clash.error().message, HasSubstr("--html and --json would both write it"));
}

OutputSet SetIn(const std::string& folder) {
  return {folder, {"states.csv", "truth.tum"}, {"states.csv", "map.yaml", "old.csv"}, {"mark"}};
}

TEST(RunFiles, ASetReplacesOlderOnesAndKeepsWhatIsRead) {
  const TempFolder temp;
  for (const char* name : {"states.csv", "truth.tum", "map.yaml", "old.csv", "mark"}) {
    WriteText(temp / name, "1");
  }
  RunFiles files;
  files.Reads("--map", temp / "map.yaml");
  const auto kept = files.WritesSet("--output", SetIn(temp.path()));
  ASSERT_TRUE(kept) << kept.error().message;
  EXPECT_THAT(*kept, ElementsAre("map.yaml"));
  RunFiles again;
  again.Reads("--ground_truth", temp / "truth.tum");
  EXPECT_FALSE(again.WritesSet("--output", SetIn(temp.path())));
}

TEST(RunFiles, WithoutAnOlderRunNothingIsRemoved) {
  const TempFolder temp;
  WriteText(temp / "map.yaml", "1");
  const auto kept = RunFiles().WritesSet("--output", SetIn(temp.path()));
  ASSERT_TRUE(kept);
  EXPECT_THAT(*kept, ElementsAre("map.yaml", "old.csv"));
}

TEST(RunFiles, ASetInARecordingReplacesAnOlderRunAlone) {
  const TempFolder temp;
  WriteText(temp / "truth.tum", "1");
  RunFiles files;
  files.ReadsRecording("--dataset", temp.path());
  EXPECT_FALSE(files.WritesSet("--output", SetIn(temp.path())));
  WriteText(temp / "mark", "1");
  RunFiles again;
  again.ReadsRecording("--dataset", temp.path());
  EXPECT_TRUE(again.WritesSet("--output", SetIn(temp.path())));
}

}  // namespace
}  // namespace tagtwist::internal::run_files_test
