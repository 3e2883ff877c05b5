// --limits: every reader has its limits from there, and a refusal says which one to raise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/support/limits_flag.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::limits_test {
namespace {

using ::testing::HasSubstr;

std::string Problem(const std::string& text) {
  const auto limits = ParseLimits(text);
  return limits ? "" : limits.error().message;
}

TEST(Limits, AreReadFromTheFlag) {
  const auto limits = ParseLimits("frame_pixels=4e8,pipe_idle_s=0.5");
  ASSERT_TRUE(limits);
  EXPECT_EQ(limits->frame_pixels, 400'000'000);
  EXPECT_EQ(limits->pipe_idle_s, 0.5);
  EXPECT_EQ(limits->nodes, Limits().nodes);
  EXPECT_EQ(Problem(""), "");
  EXPECT_EQ(Problem("nodes"), "--limits: expected KEY=NUMBER,..., got \"nodes\"");
  EXPECT_THAT(Problem("nodes=x"), HasSubstr("expected KEY=NUMBER"));
  EXPECT_THAT(Problem("frame_pixel=1e9"), HasSubstr("did you mean frame_pixels?"));
  EXPECT_EQ(Problem("nodes=1.5"), "--limits: nodes: expected a whole number, got 1.5");
  EXPECT_THAT(Problem("depth=1001"), HasSubstr("depth: expected in [1, 1000]"));
  EXPECT_THAT(Problem("depth=0"), HasSubstr("depth: expected in [1, 1000]"));
  EXPECT_THAT(Problem("file_bytes=1e300"), HasSubstr("file_bytes: expected in [1, 1e+15]"));
  EXPECT_THAT(Problem("pipe_idle_s=-1"), HasSubstr("pipe_idle_s"));
}

TEST(SlowLimits, EachReaderKeepsThem) {
  const TempFolder folder;
  MakeRecording(folder.path(), "rec", DatasetFormat::kFolder, /*images=*/true);
  MakeRecording(folder.path(), "rec.mat", DatasetFormat::kMat, /*images=*/false);
  const std::string course = std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml";
  WriteText(folder / "grid.yaml",
            "target_type: aprilgrid\ntagCols: 3\ntagRows: 2\ntagSize: 0.1\ntagSpacing: 0.3\n");
  const std::vector<std::pair<std::string, std::vector<std::string>>> runs = {
      {"text_bytes=100", {"tagtwist_estimate", "--dataset", "rec", "--config", course}},
      {"nodes=10", {"tagtwist_estimate", "--dataset", "rec", "--config", course}},
      {"key_bytes=100", {"tagtwist_estimate", "--dataset", "rec", "--camera_file", course}},
      {"depth=1", {"tagtwist_estimate", "--dataset", "rec", "--map", course}},
      {"depth=1", {"tagtwist_map", "--check", course}},
      {"tags=5", {"tagtwist_map", "--check", "grid.yaml"}},
      {"file_bytes=100", {"tagtwist_estimate", "--dataset", "rec"}},
      {"file_bytes=100",
       {"tagtwist_estimate", "--dataset", "rec.mat", "--ground_truth", "rec/ground_truth.csv"}},
      {"file_bytes=100", {"tagtwist_compare", "rec/ground_truth.csv"}},
      {"file_bytes=100", {"tagtwist_simulate", "--trajectory", "rec/ground_truth.csv"}},
      {"file_bytes=10", {"tagtwist_simulate", "--image_times", "rec/timestamps.csv"}},
      {"frame_pixels=100", {"tagtwist_estimate", "--dataset", "rec"}},
      {"fields=3", {"tagtwist_estimate", "--dataset", "rec.mat"}}};
  for (auto [limit, command] : runs) {
    const std::string program = command.front();
    command.erase(command.begin());
    if (program == "tagtwist_estimate" || program == "tagtwist_simulate") {
      command.insert(command.end(), {"--output", "out"});
    }
    command.insert(command.end(), {"--limits", limit});
    const ProgramRun run = RunProgram(folder.path(), program, command);
    EXPECT_EQ(run.status, 1) << limit;
    EXPECT_THAT(run.err,
                HasSubstr("(--limits " + limit.substr(0, limit.find('=')) + "=N raises that)"));
  }
}

}  // namespace
}  // namespace tagtwist::internal::limits_test
