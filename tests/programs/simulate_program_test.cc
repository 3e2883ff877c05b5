// tagtwist_simulate as it is run, where all goes well.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "frontend/io/recordings/data_source.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::simulate_program_test {
namespace {

using ::testing::HasSubstr;

ProgramRun Simulate(const TempFolder& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--supersampling", "2"});
  return RunProgram(folder.path(), "tagtwist_simulate", arguments);
}

TEST(SimulateProgram, SlowSameBytesTwiceAndWithAnyNumberOfThreads) {
  const TempFolder folder;
  for (const char* format : {"folder", "mat"}) {
    std::vector<std::string> names;
    for (const char* threads : {"1", "1", "3"}) {
      names.push_back(format + std::to_string(names.size()));
      const ProgramRun run = Simulate(
          folder, {"--output", names.back(), "--format", format, "--threads", threads, "--duration",
                   "1", "--rate", "8", "--trajectory", "agile", "--occluders", "5"});
      ASSERT_EQ(run.status, 0) << run.err;
    }
    for (const size_t other : {1, 2}) {
      if (std::string(format) == "mat") {
        // The first 116 bytes are a description with the date.
        EXPECT_EQ(ReadText(folder / names[0]).substr(128),
                  ReadText(folder / names[other]).substr(128));
        continue;
      }
      const auto files = ListTree(folder / names[0]);
      EXPECT_EQ(files, ListTree(folder / names[other]));
      EXPECT_GT(files.size(), 8U);
      for (const std::string& file : files) {
        if (std::filesystem::is_directory(folder / names[0] + "/" + file)) continue;
        EXPECT_EQ(ReadText(folder / (names[0] + "/" + file)),
                  ReadText(folder / (names[other] + "/" + file)))
            << file;
      }
    }
  }
}

TEST(SimulateProgram, FramesStandAtTheGivenTimesWithExactTruth) {
  const TempFolder folder;
  WriteText(folder / "times.csv", "n,t\n0,-0.5\n1,0.25\n2,0.310000001\n3,1.5\n4,9\n");
  const ProgramRun run =
      Simulate(folder, {"--output", "out", "--image_times", "times.csv", "--duration", "2"});
  EXPECT_EQ(run.status, 0);
  EXPECT_EQ(run.err,
            "tagtwist_simulate: times.csv: 2 of 5 stamps lie outside the flight and are left "
            "out\n");
  EXPECT_THAT(run.out, HasSubstr("out: 3 frames"));
  const auto source = OpenDataSource(folder / "out", {});
  ASSERT_TRUE(source) << source.error().message;
  const std::vector<int64_t> expected = {250000000, 310000001, 1500000000};
  EXPECT_EQ((*source)->stamps_ns(), expected);
  ASSERT_EQ((*source)->ground_truth().size(), 3U);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ((*source)->ground_truth()[i].t_ns, expected[i]);
    EXPECT_TRUE((*source)->ground_truth()[i].twist);
  }
  EXPECT_EQ((*source)->imu().size(), 251U);
}

TEST(SimulateProgram, WritesDetectionsAloneWhenAsked) {
  const TempFolder folder;
  const ProgramRun run =
      Simulate(folder, {"--output", "out", "--images=false", "--duration", "1", "--rate", "10"});
  ASSERT_EQ(run.status, 0) << run.err;
  DataSourceOptions options;
  options.use_detections = true;
  const auto source = OpenDataSource(folder / "out", options);
  ASSERT_TRUE(source) << source.error().message;
  const auto frame = (*source)->Next();
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_TRUE((*frame)->image.empty());
  EXPECT_GE((*frame)->detections.size(), 6U);
}

TEST(SimulateProgram, TrajectoryFileIsFlownWithColumnsInAnyOrder) {
  const TempFolder folder;
  std::string text = "t,roll,qw,qx,qy,qz,x,y,z\n";
  for (int i = 0; i <= 20; ++i) {
    text +=
        std::to_string(5 + 0.1 * i) + ",9,1,0,0,0," + std::to_string(1 + 0.05 * i) + ",1.2,1.3\n";
  }
  WriteText(folder / "path.csv", text);
  const ProgramRun run =
      Simulate(folder, {"--output", "out", "--trajectory", "path.csv", "--rate", "10"});
  ASSERT_EQ(run.status, 0) << run.err;
  const auto source = OpenDataSource(folder / "out", {});
  ASSERT_TRUE(source) << source.error().message;
  for (const TruthSample& truth : (*source)->ground_truth()) {
    const double t = ToSeconds(truth.t_ns) - 5;
    EXPECT_LT((truth.world_from_body.translation() - Eigen::Vector3d(1 + 0.5 * t, 1.2, 1.3)).norm(),
              1e-4);
    EXPECT_LT((truth.twist->v_world - Eigen::Vector3d(0.5, 0, 0)).norm(), 1e-3);
  }
}

TEST(SimulateProgram, HelpNamesEveryFlagAndVersionIsANumber) {
  const TempFolder folder;
  const ProgramRun help = Simulate(folder, {"--help"});
  EXPECT_EQ(help.status, 0);
  for (const char* flag : {"--output", "--trajectory", "--image_times", "--config", "--seed",
                           "--format", "--occluders", "--threads"}) {
    EXPECT_THAT(help.out, HasSubstr(flag));
  }
  const ProgramRun version = Simulate(folder, {"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_THAT(version.out, ::testing::MatchesRegex("tagtwist_simulate [0-9.]+\n"));
}

// A flight along the real path at the real image times: all frames, and tags in nearly all.
TEST(RealDataSimulate, FliesTheViconPaths) {
  const std::string course = std::string(TAGTWIST_REAL_DATA_DIR) + "/course/";
  if (!std::filesystem::exists(course)) GTEST_SKIP() << "no real data beside the project";
  const TempFolder folder;
  for (const auto& [trial, frames] : {std::pair{"1", 864}, {"4", 373}}) {
    const ProgramRun run =
        Simulate(folder, {"--output", trial, "--images=false", "--trajectory",
                          course + "vicon_dataset" + trial + ".csv", "--image_times",
                          course + "image_times_dataset" + trial + ".csv"});
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_EQ(run.err, "");
    EXPECT_THAT(run.out, HasSubstr(": " + std::to_string(frames) + " frames"));
    DataSourceOptions options;
    options.use_detections = true;
    const auto source = OpenDataSource(folder / trial, options);
    ASSERT_TRUE(source) << source.error().message;
    int with_tags = 0;
    for (auto frame = (*source)->Next(); frame && *frame; frame = (*source)->Next()) {
      with_tags += !(*frame)->detections.empty();
    }
    EXPECT_GT(with_tags, 95 * frames / 100);
  }
}

// A calibration without a mount makes the camera the body, which looks up as it flies.
TEST(SimulateProgram, SaysSoWhenNoFrameSeesATag) {
  const TempFolder folder;
  WriteText(folder / "up.yaml",
            "cam_from_body: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 0]}\n");
  const ProgramRun up = RunProgram(folder.path(), "tagtwist_simulate",
                                   {"--config", "up.yaml", "--output", "up", "--images=false",
                                    "--duration", "1", "--rate", "5"});
  EXPECT_EQ(up.status, 0);
  EXPECT_NE(up.err.find("no frame sees a tag"), std::string::npos) << up.err;
  const ProgramRun down =
      RunProgram(folder.path(), "tagtwist_simulate",
                 {"--output", "down", "--images=false", "--duration", "1", "--rate", "5"});
  EXPECT_EQ(down.err, "");
}

}  // namespace
}  // namespace tagtwist::internal::simulate_program_test
