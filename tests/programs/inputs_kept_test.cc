// What a program reads it never overwrites or removes, whatever the flags say.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::inputs_kept_test {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;
using ::testing::HasSubstr;

class InputsKept : public testing::Test {
 protected:
  void SetUp() override {
    MakeRecording(folder_.path(), "rec", DatasetFormat::kFolder, /*images=*/false);
    fs::copy_file(std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml", folder_ / "c.yaml");
  }
  ProgramRun Run(const std::string& program, const Arguments& arguments) {
    return RunProgram(folder_.path(), program, arguments);
  }
  ProgramRun Estimate(const Arguments& more) {
    Arguments arguments = {"--dataset", "rec", "--use_detections"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run("tagtwist_estimate", arguments);
  }
  // Refused in one line, and `name` as it was.
  void ExpectRefused(const std::string& program, const Arguments& arguments,
                     const std::string& name) {
    const std::string before = ReadText(folder_ / name);
    const auto tree = ListTree(folder_.path());
    const ProgramRun run = Run(program, arguments);
    EXPECT_EQ(run.status, 1) << run.out;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
    EXPECT_THAT(run.err, HasSubstr(name + ": "));
    EXPECT_EQ(ReadText(folder_ / name), before);
    EXPECT_EQ(ListTree(folder_.path()), tree) << "nothing was begun";
  }
  void ExpectEstimateRefused(const Arguments& more, const std::string& name) {
    Arguments arguments = {"--dataset", "rec", "--use_detections"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ExpectRefused("tagtwist_estimate", arguments, name);
  }

  TempFolder folder_;
};

TEST_F(InputsKept, TheSetUpThatACalibrationWroteStays) {
  fs::remove_all(folder_ / "rec");
  ASSERT_EQ(Run("tagtwist_simulate",
                {"--output", "rec", "--images=false", "--duration", "4", "--rate", "20"})
                .status,
            0);
  const ProgramRun calibrated = Estimate({"--calibrate", "--output", "res"});
  ASSERT_EQ(calibrated.status, 0) << calibrated.err;
  const std::string setup = ReadText(folder_ / "res/calibration.yaml");
  const std::string states = ReadText(folder_ / "res/states.csv");
  ASSERT_FALSE(setup.empty());
  const ProgramRun run =
      Estimate({"--config", "res/calibration.yaml", "--output", "res", "--max_frames", "30"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(ReadText(folder_ / "res/calibration.yaml"), setup);
  EXPECT_NE(ReadText(folder_ / "res/states.csv"), states) << "an older run's results are replaced";
  ExpectEstimateRefused({"--calibrate", "--config", "res/calibration.yaml", "--output", "res"},
                        "res/calibration.yaml");
}

TEST_F(InputsKept, AMapAmongOlderResultsStays) {
  ASSERT_EQ(Estimate({"--output", "res"}).status, 0);
  fs::copy_file(folder_ / "c.yaml", folder_ / "res/map.yaml");
  const std::string map = ReadText(folder_ / "res/map.yaml");
  const ProgramRun run = Estimate({"--map", "res/map.yaml", "--output", "res"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(ReadText(folder_ / "res/map.yaml"), map);
  const ProgramRun other = Estimate({"--output", "res"});
  EXPECT_EQ(other.status, 0) << other.err;
  EXPECT_FALSE(fs::exists(folder_ / "res/map.yaml")) << "of an older run, and not read";
}

TEST_F(InputsKept, AFolderWithoutOlderResultsLosesNothing) {
  fs::create_directory(folder_ / "res");
  WriteText(folder_ / "res/map.yaml", "mine");
  ASSERT_EQ(Estimate({"--output", "res"}).status, 0);
  EXPECT_EQ(ReadText(folder_ / "res/map.yaml"), "mine");
}

TEST_F(InputsKept, TruthInARecordingThatIsAlsoTheOutputStays) {
  WriteText(folder_ / "rec/ground_truth.tum", "0 0 0 1 0 0 0 1\n");
  ExpectEstimateRefused({"--output", "rec"}, "rec/ground_truth.tum");
  fs::remove(folder_ / "rec/ground_truth.tum");
  EXPECT_EQ(Estimate({"--output", "rec"}).status, 0);
  const ProgramRun again = Estimate({"--output", "rec"});
  EXPECT_EQ(again.status, 0) << again.err;
}

TEST_F(InputsKept, StreamsGoOntoNothingThatIsRead) {
  fs::copy_file(folder_ / "rec/ground_truth.csv", folder_ / "truth.csv");
  fs::create_symlink("truth.csv", folder_ / "link.csv");
  const Arguments window = {"--sliding_window", "--output", "res", "--stream"};
  const auto to = [&](const std::string& name, const Arguments& more) {
    Arguments arguments = window;
    arguments.push_back(name);
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  ExpectEstimateRefused(to("truth.csv", {"--ground_truth", "truth.csv"}), "truth.csv");
  ExpectEstimateRefused(to("link.csv", {"--ground_truth", "truth.csv"}), "link.csv");
  ExpectEstimateRefused(to("rec/detections.csv", {}), "rec/detections.csv");
  ExpectEstimateRefused(to("c.yaml", {"--config", "c.yaml"}), "c.yaml");
}

TEST_F(InputsKept, AnOverlayGoesOntoNothingThatIsRead) {
  MakeRecording(folder_.path(), "images", DatasetFormat::kFolder, /*images=*/true);
  const ProgramRun first = Run(
      "tagtwist_estimate", {"--dataset", "images", "--output", "res", "--overlay", "flight.mp4"});
  ASSERT_EQ(first.status, 0) << first.err;
  ExpectRefused("tagtwist_estimate",
                {"--dataset", "flight.mp4", "--output", "res", "--overlay", "flight.mp4"},
                "flight.mp4");
}

TEST_F(InputsKept, MapsAreNotDrawnOverThemselves) {
  ExpectRefused("tagtwist_map", {"--map", "c.yaml", "--render", "c.yaml"}, "c.yaml");
  ExpectRefused("tagtwist_map", {"--check", "c.yaml", "--render", "c.yaml"}, "c.yaml");
  ExpectRefused("tagtwist_map",
                {"--from", "rec", "--use_detections", "--tag_size_m", "0.152", "--output",
                 "rec/detections.csv"},
                "rec/detections.csv");
}

TEST_F(InputsKept, FiguresDoNotReplaceTrajectories) {
  WriteText(folder_ / "o.tum", "0 1 1 1 0 0 0 1\n1 2 1 1 0 0 0 1\n2 3 1 1 0 0 0 1\n");
  fs::copy_file(folder_ / "o.tum", folder_ / "truth.tum");
  const std::string compare = "tagtwist_compare";
  const Arguments input = {"o.tum", "--ground_truth", "truth.tum"};
  for (const auto& [flag, name] : {std::pair("--json", "o.tum"), {"--html", "truth.tum"}}) {
    Arguments arguments = input;
    arguments.insert(arguments.end(), {flag, name});
    ExpectRefused(compare, arguments, name);
  }
  ASSERT_EQ(Estimate({"--output", "res"}).status, 0);
  ExpectRefused(compare, {"res", "--json", "res/states.csv"}, "res/states.csv");
  for (int run = 0; run < 2; ++run) {
    EXPECT_EQ(Run(compare, {"res", "--html", "res/compare.html"}).status, 0) << run;
  }
}

TEST_F(InputsKept, ASimulationReplacesNothing) {
  ExpectRefused("tagtwist_simulate", {"--config", "c.yaml", "--output", "c.yaml"}, "c.yaml");
}

}  // namespace
}  // namespace tagtwist::internal::inputs_kept_test
