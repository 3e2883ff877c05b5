// What a run takes, passes over and doubts is told on the terminal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "tests/support/program_test_util.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::inputs_told_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using Arguments = std::vector<std::string>;

class InputsTold : public ::testing::Test {
 protected:
  InputsTold() { MakeRecording(folder_.path(), "rec", DatasetFormat::kFolder, false); }

  ProgramRun Estimate(const Arguments& more = {}) {
    Arguments all = {"--dataset", "rec", "--output", "out", "--use_detections", "--tracks=false"};
    all.insert(all.end(), more.begin(), more.end());
    return RunProgram(folder_.path(), "tagtwist_estimate", all);
  }
  std::string Path(const std::string& name) const { return folder_.path() + "/" + name; }
  std::string Line(const std::string& file, size_t number) const {
    std::istringstream lines(ReadText(Path(file)));
    std::string line;
    for (size_t i = 0; i < number; ++i) std::getline(lines, line);
    return line;
  }

  const TempFolder folder_;
};

TEST_F(InputsTold, ARightSetUpIsDescribedAndNothingDoubted) {
  const ProgramRun run = Estimate();
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(run.out, HasSubstr("recording  rec: 6 frames, 50 Hz, 0.10 s"));
  EXPECT_THAT(run.out, HasSubstr("camera     376 x 240 px, fx 311.1, fy 311.4, no distortion"));
  EXPECT_THAT(run.out, HasSubstr("mount      cam_from_body"));
  EXPECT_THAT(run.out, HasSubstr("map        108 tags of tag36h11, 152 mm, from the course's mat"));
  EXPECT_THAT(run.out, HasSubstr("6 of 6 frames lie in its time"));
}

TEST_F(InputsTold, TheSummaryHasTheInputsWithTheirDigests) {
  EXPECT_EQ(Estimate().status, 0);
  const std::string summary = ReadText(Path("out/summary.json"));
  EXPECT_THAT(summary, HasSubstr("\"status\": \"done\""));
  EXPECT_THAT(summary, HasSubstr("rec/detections.csv"));
  EXPECT_THAT(summary, HasSubstr("recording  rec: 6 frames"));
  EXPECT_THAT(summary, ::testing::ContainsRegex("\"sha256\": \"[0-9a-f]+\""));
}

// Corners that were written, with covariances, give the same poses when they are read again.
TEST_F(InputsTold, WrittenDetectionsRepeatTheRun) {
  MakeRecording(folder_.path(), "pictures", DatasetFormat::kFolder, true);
  const ProgramRun first = RunProgram(
      folder_.path(), "tagtwist_estimate",
      {"--dataset", "pictures", "--tracks=false", "--write_detections", "--output", "a"});
  ASSERT_EQ(first.status, 0) << first.err;
  fs::create_directory(Path("again"));
  fs::copy_file(Path("a/detections.csv"), Path("again/detections.csv"));
  const ProgramRun second =
      RunProgram(folder_.path(), "tagtwist_estimate",
                 {"--dataset", "again", "--use_detections", "--tracks=false", "--output", "b"});
  ASSERT_EQ(second.status, 0) << second.err;
  std::istringstream a(ReadText(Path("a/optimised.tum"))), b(ReadText(Path("b/optimised.tum")));
  std::string header;
  std::getline(a, header);
  std::getline(b, header);
  int numbers = 0;
  for (double x = 0, y = 0; a >> x && b >> y; ++numbers) EXPECT_NEAR(x, y, 1e-9);
  EXPECT_EQ(numbers % 8, 0);
  EXPECT_GT(numbers, 0);
}

// The window writes the corners that it used, searched or guided, and names the same mistakes.
TEST_F(InputsTold, TheWindowWritesItsDetectionsToo) {
  const ProgramRun run = Estimate({"--sliding_window", "--write_detections"});
  ASSERT_EQ(run.status, 0) << run.err;
  std::istringstream given(ReadText(Path("rec/detections.csv")));
  std::istringstream written(ReadText(Path("out/detections.csv")));
  size_t lines = 0;
  std::string one, other;
  std::getline(given, one);
  std::getline(written, other);
  for (; std::getline(given, one) && std::getline(written, other); ++lines) {
    EXPECT_EQ(other.rfind(one.substr(0, 30), 0), 0u) << one << "\n" << other;
  }
  EXPECT_GT(lines, 20u);
  MakeRecording(folder_.path(), "pictures", DatasetFormat::kFolder, true);
  const ProgramRun guided = RunProgram(folder_.path(), "tagtwist_estimate",
                                       {"--dataset", "pictures", "--sliding_window",
                                        "--tracks=false", "--write_detections", "--output", "g"});
  ASSERT_EQ(guided.status, 0) << guided.err;
  EXPECT_GT(ReadText(Path("g/detections.csv")).size(), 5000u);
}

TEST_F(InputsTold, FailOnWarningsEndsWithStatus3) {
  ReplaceLine(Path("rec/imu.csv"), 4, Line("rec/imu.csv", 3));
  EXPECT_EQ(Estimate().status, 0);
  EXPECT_EQ(Estimate({"--fail_on", "warnings"}).status, 3);
  EXPECT_TRUE(fs::exists(Path("out/states.csv")));
  EXPECT_EQ(Estimate({"--fail_on", "anything"}).status, 2);
}

TEST_F(InputsTold, BadRowsArePassedOverAndCounted) {
  ReplaceLine(Path("rec/timestamps.csv"), 3, "0.000000000,");
  ReplaceLine(Path("rec/ground_truth.csv"), 4, Line("rec/ground_truth.csv", 3));
  ReplaceLine(Path("rec/imu.csv"), 4, Line("rec/imu.csv", 3));
  std::string detection = Line("rec/detections.csv", 2);
  ReplaceLine(Path("rec/detections.csv"), 3, detection.substr(0, detection.rfind(',')) + ",nan");
  const ProgramRun run = Estimate();
  EXPECT_EQ(run.status, 0) << run.err;
  for (const char* file :
       {"timestamps.csv: passed over 1 of 6 rows", "ground_truth.csv: passed over 1 of",
        "imu.csv: passed over 1 of", "detections.csv: passed over 1 rows"}) {
    EXPECT_THAT(run.err, HasSubstr(file));
  }
}

TEST_F(InputsTold, StampsInAnotherUnitAreReadAndTold) {
  fs::remove(Path("rec/timestamps.csv"));
  fs::remove(Path("rec/imu.csv"));
  fs::remove(Path("rec/ground_truth.csv"));
  std::istringstream lines(ReadText(Path("rec/detections.csv")));
  std::string line, text;
  std::getline(lines, line);
  text = line + "\n";
  while (std::getline(lines, line)) {
    const size_t comma = line.find(',');
    const double t_ms = 1.4e12 + 1e3 * std::stod(line.substr(0, comma));
    text += std::to_string(static_cast<long long>(t_ms)) + line.substr(comma) + "\n";
  }
  WriteText(Path("rec/detections.csv"), text);
  const ProgramRun run = Estimate();
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("taken for milliseconds"));
  EXPECT_THAT(run.out, HasSubstr("50 Hz"));
}

TEST_F(InputsTold, ACameraOfOnesOwnNeedsAMap) {
  WriteText(Path("camera.yaml"), "width: 376\nheight: 240\nfx: 311\nfy: 311\ncx: 201\ncy: 113\n");
  const ProgramRun run = Estimate({"--camera_file", "camera.yaml"});
  EXPECT_EQ(run.status, 1);
  EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  EXPECT_THAT(run.err, HasSubstr("camera.yaml: a camera of your own needs a map"));
  EXPECT_FALSE(fs::exists(Path("out")));
}

// OpenVINS writes the inverse of Kalibr's mount; either gives the same body.
TEST_F(InputsTold, EitherDirectionOfTheMountIsRead) {
  const std::string camera =
      "cam0:\n  camera_model: pinhole\n  intrinsics: [311.052, 311.3885, 201.8724, 113.621]\n"
      "  distortion_model: none\n  resolution: [376, 240]\n";
  WriteText(Path("kalibr.yaml"),
            camera +
                "  T_cam_imu: [[0, -1, 0, 0.1], [1, 0, 0, 0.2], [0, 0, 1, 0.3], "
                "[0, 0, 0, 1]]\n  timeshift_cam_imu: 0.01\n");
  WriteText(Path("openvins.yaml"), camera +
                                       "  T_imu_cam: [[0, 1, 0, -0.2], [-1, 0, 0, 0.1], [0, 0, 1, "
                                       "-0.3], [0, 0, 0, 1]]\n");
  WriteText(Path("map.yaml"),
            "tag_map: {grid: {rows: 12, columns: 9, tag_size_m: 0.152, row_gaps_m: 0.152, "
            "column_gaps_m: [0.152, 0.152, 0.178, 0.152, 0.152, 0.178, 0.152, 0.152]}}\n");
  const ProgramRun kalibr = Estimate({"--camera_file", "kalibr.yaml", "--map", "map.yaml"});
  EXPECT_EQ(kalibr.status, 0) << kalibr.err;
  EXPECT_THAT(kalibr.out, HasSubstr("T_cam_imu of kalibr.yaml"));
  EXPECT_THAT(kalibr.err, HasSubstr("timeshift_cam_imu is not used"));
  const std::string poses = ReadText(Path("out/optimised.tum"));
  const ProgramRun openvins = Estimate({"--camera_file", "openvins.yaml", "--map", "map.yaml"});
  EXPECT_EQ(openvins.status, 0) << openvins.err;
  EXPECT_THAT(openvins.out, HasSubstr("T_imu_cam of openvins.yaml"));
  std::istringstream a(poses), b(ReadText(Path("out/optimised.tum")));
  std::string one, other;
  while (a >> one && b >> other) {
    if (one.find_first_of("#xyzqtw") == std::string::npos) {
      EXPECT_NEAR(std::stod(one), std::stod(other), 1e-9);
    }
  }
}

TEST_F(InputsTold, TheCauseIsNamed) {
  // Corners in ArUco's order.
  std::istringstream lines(ReadText(Path("rec/detections.csv")));
  std::string line, text;
  std::getline(lines, line);
  text = line + "\n";
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    text += cells[0] + "," + cells[1];
    for (int corner = 3; corner >= 0; --corner) {
      text += "," + cells[static_cast<size_t>(2 + 2 * corner)] + "," +
              cells[static_cast<size_t>(3 + 2 * corner)];
    }
    text += "\n";
  }
  WriteText(Path("rec/detections.csv"), text);
  const ProgramRun run = Estimate();
  EXPECT_THAT(run.err, HasSubstr("ArUco"));
}

TEST_F(InputsTold, WidthAndHeightExchangedAreTold) {
  const std::string camera = "fx: 311.052\nfy: 311.3885\ncx: 201.8724\ncy: 113.621\n";
  WriteText(Path("camera.yaml"), "width: 240\nheight: 376\n" + camera);
  const ProgramRun run = Estimate({"--camera_file", "camera.yaml", "--config",
                                   std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("corners lie off the camera's image of 240 x 376 px."));
}

TEST_F(InputsTold, TruthOfAnotherTimeIsRefusedWithBothSpans) {
  WriteText(Path("truth.tum"), "100 0 0 0 0 0 0 1\n101 0 0 0 0 0 0 1\n");
  const ProgramRun run = Estimate({"--ground_truth", "truth.tum"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err,
              HasSubstr("no sample lies within the recording: it has 100.000 to 101.000 s, "
                        "the recording 0.000 to 0.100 s"));
}

}  // namespace
}  // namespace tagtwist::internal::inputs_told_test
