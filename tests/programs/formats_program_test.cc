// Every format of cameras, maps and recordings, as tagtwist_estimate takes them: the same flight
// gives the same trajectory, and a broken file one line and status 1.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>

#include "frontend/io/tables/csv.h"
#include "tests/support/formats/camera_formats.h"
#include "tests/support/formats/map_formats.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::formats_program_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Arguments = std::vector<std::string>;

// Looks down, as the flights fly.
const std::string kMount =
    "cam_from_body: {rotation: [0, -1, 0, -1, 0, 0, 0, 0, -1], translation_m: [0.04, 0, -0.03]}\n";

class FormatsProgram : public testing::Test {
 protected:
  void SetUp() override { WriteText(folder_ / "mount.yaml", kMount); }

  ProgramRun Run(const std::string& program, const Arguments& arguments) {
    return RunProgram(folder_.path(), program, arguments);
  }
  void RunWell(const std::string& program, const Arguments& arguments) {
    const ProgramRun run = Run(program, arguments);
    ASSERT_EQ(run.status, 0) << run.err;
  }
  // The rows of states.csv that an estimate gives.
  std::vector<std::vector<double>> Estimate(Arguments arguments) {
    arguments.insert(arguments.end(), {"--output", "out"});
    RunWell("tagtwist_estimate", arguments);
    std::ifstream in(folder_ / "out/optimised.tum");
    std::vector<std::vector<double>> out;
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      out.emplace_back();
      for (double number = 0; words >> number;) out.back().push_back(number);
    }
    EXPECT_GT(out.size(), 5u);
    return out;
  }
  void ExpectSame(const std::vector<std::vector<double>>& a,
                  const std::vector<std::vector<double>>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].size(), b[i].size());
      for (size_t k = 0; k < a[i].size(); ++k) EXPECT_NEAR(a[i][k], b[i][k], 1e-9) << i << " " << k;
    }
  }
  void ExpectRefused(Arguments arguments, const std::string& fault) {
    arguments.insert(arguments.end(), {"--output", "refused"});
    const ProgramRun run = Run("tagtwist_estimate", arguments);
    EXPECT_EQ(run.status, 1) << fault;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
    EXPECT_THAT(run.err, HasSubstr(fault));
    EXPECT_TRUE(HasNoResults(folder_ / "refused"));
  }

  TempFolder folder_;
};

TEST_F(FormatsProgram, SlowEveryCameraFormatGivesTheSameTrajectory) {
  WriteText(folder_ / "own.yaml", kOwnCamera);
  WriteText(folder_ / "chain.yaml", kKalibrCamchain);
  WriteText(folder_ / "opencv.yml", kOpenCvYaml);
  WriteText(folder_ / "opencv.xml", kOpenCvXml);
  WriteText(folder_ / "ros.yaml", kRosCameraInfo);
  WriteText(folder_ / "echo.yaml", kRosTopicEcho);
  RunWell("tagtwist_simulate", {"--config", "mount.yaml", "--camera_file", "own.yaml", "--output",
                                "rec", "--images=false", "--duration", "1", "--rate", "20"});
  const std::string map = std::string(TAGTWIST_SOURCE_DIR) + "/configs/course.yaml";
  const Arguments common = {"--dataset", "rec", "--use_detections", "--config", "mount.yaml",
                            "--map",     map};
  const auto with = [&](const Arguments& camera) {
    Arguments out = common;
    out.insert(out.end(), camera.begin(), camera.end());
    return out;
  };
  const auto own = Estimate(with({"--camera_file", "own.yaml"}));
  for (const std::string file : {"opencv.yml", "opencv.xml", "ros.yaml", "echo.yaml"}) {
    SCOPED_TRACE(file);
    ExpectSame(Estimate(with({"--camera_file", file})), own);
  }
  ExpectSame(Estimate(with({"--camera_file", "chain.yaml", "--camera", "cam1"})), own);

  ExpectRefused(with({"--camera_file", "chain.yaml"}), "expected one of cam0, cam1");
  WriteText(folder_ / "cut.xml", std::string(kOpenCvXml).substr(0, 126));
  ExpectRefused(with({"--camera_file", "cut.xml"}), "cut.xml:5: not valid XML");
  EXPECT_EQ(Run("tagtwist_estimate", with({"--camera", "cam1"})).status, 2);
}

TEST_F(FormatsProgram, EveryMapFormatGivesTheSameTrajectory) {
  WriteText(folder_ / "own.yaml", kOwnMap);
  WriteText(folder_ / "field.json", kWpilibField);
  WriteText(folder_ / "tagslam.yaml", kTagSlam);
  RunWell("tagtwist_simulate",
          {"--config", "mount.yaml", "--map", "own.yaml", "--output", "rec", "--images=false",
           "--duration", "1", "--rate", "20", "--trajectory", "hover", "--height", "2"});
  const Arguments common = {"--dataset", "rec", "--use_detections", "--config", "mount.yaml"};
  const auto with = [&](const Arguments& map) {
    Arguments out = common;
    out.insert(out.end(), map.begin(), map.end());
    return out;
  };
  const auto own = Estimate(with({"--map", "own.yaml"}));
  ExpectSame(Estimate(with({"--map", "field.json", "--tag_size_m", "0.2"})), own);
  ExpectSame(Estimate(with({"--map", "tagslam.yaml"})), own);

  ExpectRefused(with({"--map", "field.json"}), "field.json: the size of the tags is not");
  WriteText(folder_ / "cut.json", std::string(kWpilibField).substr(0, 300));
  ExpectRefused(with({"--map", "cut.json", "--tag_size_m", "0.2"}), "cut.json:");
  EXPECT_EQ(Run("tagtwist_estimate", with({"--tag_size_m", "0.2"})).status, 2);
}

class RecordingFormats : public FormatsProgram {
 protected:
  void SetUp() override {
    RunWell("tagtwist_simulate", {"--output", "rec", "--duration", "1", "--rate", "20",
                                  "--jitter_ms", "0", "--supersampling", "2"});
    const auto table = CsvTable::Read(folder_ / "rec/timestamps.csv");
    ASSERT_TRUE(table);
    for (size_t row = 0; row < table->rows(); ++row) {
      stamps_ns_.push_back(*table->Seconds(row, 0));
      files_.push_back(folder_ / ("rec/" + std::string(table->Cell(row, 1))));
    }
  }
  // Without loss, at 20 frames a second.
  void WriteVideo(const std::string& path) {
    const cv::Mat first = cv::imread(files_[0], cv::IMREAD_GRAYSCALE);
    cv::VideoWriter writer(path, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), 20,
                           first.size());
    ASSERT_TRUE(writer.isOpened());
    for (const std::string& file : files_) {
      cv::Mat colour;
      cv::cvtColor(cv::imread(file, cv::IMREAD_GRAYSCALE), colour, cv::COLOR_GRAY2BGR);
      writer.write(colour);
    }
  }
  std::vector<int64_t> stamps_ns_;
  std::vector<std::string> files_;
};

TEST_F(RecordingFormats, SlowImagesNamedByStampsAreTheSameFlight) {
  const auto folder = Estimate({"--dataset", "rec"});
  fs::create_directory(folder_ / "ns");
  fs::create_directory(folder_ / "s");
  for (size_t i = 0; i < files_.size(); ++i) {
    const std::string ns = std::to_string(stamps_ns_[i]);
    fs::copy_file(files_[i], folder_ / ("ns/" + ns + ".png"));
    const std::string fraction = std::to_string(1000000000 + stamps_ns_[i] % 1000000000).substr(1);
    fs::copy_file(files_[i], folder_ / ("s/left_" + std::to_string(stamps_ns_[i] / 1000000000) +
                                        "." + fraction + ".png"));
  }
  ExpectSame(Estimate({"--dataset", "ns"}), folder);
  ExpectSame(Estimate({"--dataset", "s"}), folder);
  fs::copy_file(files_[0], folder_ / "ns/000.png");
  const ProgramRun twice = Run("tagtwist_estimate", {"--dataset", "ns", "--output", "twice"});
  EXPECT_EQ(twice.status, 0) << twice.err;
  EXPECT_THAT(twice.err, HasSubstr("ns/000.png: passed over, its stamp is another image's"));
  fs::remove(folder_ / "ns/000.png");
  fs::copy_file(files_[0], folder_ / "s/left.png");
  ExpectRefused({"--dataset", "s"}, "left.png: expected a stamp for a name");
  ExpectRefused({"--dataset", "rec/images"}, "names are numbers, not stamps");
}

TEST_F(RecordingFormats, SlowAVideoIsTheSameFlight) {
  const auto folder = Estimate({"--dataset", "rec"});
  WriteVideo(folder_ / "flight.mkv");
  WriteVideo(folder_ / "flight.avi");
  ExpectSame(Estimate({"--dataset", "flight.mkv"}), folder);
  ExpectSame(Estimate({"--dataset", "flight.avi"}), folder);

  fs::copy_file(folder_ / "flight.avi", folder_ / "cut.avi");
  Truncate(folder_ / "cut.avi", static_cast<long>(fs::file_size(folder_ / "cut.avi") / 2));
  ExpectRefused({"--dataset", "cut.avi"}, "cut.avi: a damaged video: ");
  WriteText(folder_ / "noise.mp4", Garbage());
  ExpectRefused({"--dataset", "noise.mp4"}, "noise.mp4: expected a course .mat, a video");
  ExpectRefused({"--dataset", "flight.mkv", "--use_detections"}, "a video has no detections");
}

// Tracks left out of a calibration, which takes none, are not left out of what comes after it.
TEST_F(FormatsProgram, SlowACalibrationWithoutTracksIsFlownWithThem) {
  RunWell("tagtwist_simulate", {"--config", "mount.yaml", "--output", "rec", "--images=false",
                                "--duration", "2", "--rate", "20"});
  for (const std::string given : {"true", "false"}) {
    WriteText(folder_ / "set.yaml", kMount + "estimator: {use_tracks: " + given + "}\n");
    Estimate({"--dataset", "rec", "--config", "set.yaml", "--use_detections", "--notracks",
              "--calibrate"});
    EXPECT_THAT(ReadText(folder_ / "out/calibration.yaml"), HasSubstr("use_tracks: " + given));
  }
}

// A floor of 6 x 6 tags and two walls of 6 x 4; the camera looks 35 degrees down and turns.
std::string Room() {
  std::ostringstream out;
  out << "camera: {width: 640, height: 480, fx: 400, fy: 400, cx: 320, cy: 240}\n"
         "cam_from_body: {rotation: [0, -1, 0, -0.573576436351046, 0, -0.819152044288992, "
         "0.819152044288992, 0, -0.573576436351046], translation_m: [0.05, 0.02, -0.01]}\n"
         "tag_map:\n  tags:\n";
  int id = 0;
  const auto add = [&](double x, double y, double z, const char* rotation) {
    out << "    - {id: " << id++ << ", size_m: 0.2, position_m: [" << x << ", " << y << ", " << z
        << "], rotation: [" << rotation << "]}\n";
  };
  for (int i = 0; i < 36; ++i)
    add(0.25 + 0.5 * (i / 6), 0.25 + 0.5 * (i % 6), 0, "1,0,0,0,1,0,0,0,1");
  for (int i = 0; i < 24; ++i)
    add(3, 0.25 + 0.5 * (i % 6), 0.3 + 0.5 * (i / 6), "0,0,-1,-1,0,0,0,1,0");
  for (int i = 0; i < 24; ++i)
    add(0.25 + 0.5 * (i % 6), 3, 0.3 + 0.5 * (i / 6), "1,0,0,0,0,-1,0,1,0");
  return out.str();
}

using SlowFormatsProgram = FormatsProgram;

// What Kalibr users have: its camchain and its grid of tags with wide borders.
TEST_F(SlowFormatsProgram, AnAprilGridThroughARadtanLensIsEstimatedToTheBound) {
  WriteText(folder_ / "chain.yaml", kKalibrCamchain);
  WriteText(folder_ / "grid.yaml",
            "{target_type: aprilgrid, tagCols: 6, tagRows: 6, tagSize: 0.088, tagSpacing: 0.3}\n");
  const Arguments setup = {"--config", "mount.yaml", "--camera_file", "chain.yaml",
                           "--camera", "cam1",       "--map",         "grid.yaml"};
  Arguments simulate = setup, estimate = setup;
  simulate.insert(simulate.end(), {"--output", "rec", "--duration", "4", "--rate", "15", "--height",
                                   "0.6", "--supersampling", "3"});
  RunWell("tagtwist_simulate", simulate);
  estimate.insert(estimate.end(), {"--dataset", "rec"});
  Estimate(estimate);
  const auto summary = nlohmann::json::parse(ReadText(folder_ / "out/summary.json"));
  EXPECT_EQ(summary["frames_estimated"], summary["frames"]);
  EXPECT_LT(summary["reprojection_px"]["median"].get<double>(), 0.05);
  for (const char* key : {"position", "rotation", "velocity"}) {
    EXPECT_LT(summary["bound"]["rmse_over_bound"][key].get<double>(), 1.2) << key;
  }
}

// Over six seconds: in shorter flights the speeding up and slowing down, which no white noise on
// jerk describes, is most of it, and rates go beyond the bound.
TEST_F(SlowFormatsProgram, AFloorAndTwoWallsAreEstimatedToTheBound) {
  WriteText(folder_ / "room.yaml", Room());
  RunWell("tagtwist_simulate",
          {"--config", "room.yaml", "--output", "rec", "--trajectory", "circle", "--height", "1",
           "--duration", "6", "--rate", "20", "--supersampling", "2", "--walls"});
  for (const std::string mode : {"--nosliding_window", "--sliding_window"}) {
    Estimate({"--config", "room.yaml", "--dataset", "rec", mode});
    const auto summary = nlohmann::json::parse(ReadText(folder_ / "out/summary.json"));
    EXPECT_EQ(summary["frames_estimated"], summary["frames"]);
    for (const char* key : {"position", "rotation", "velocity", "rate"}) {
      EXPECT_LT(summary["bound"]["rmse_over_bound"][key].get<double>(), 1.2) << mode << key;
    }
  }
}

// Images that show all, but no detections for a while: tracked points on the floor and the walls
// bridge it.
TEST_F(SlowFormatsProgram, TracksOnAFloorAndTwoWallsBridgeAGap) {
  WriteText(folder_ / "room.yaml", Room());
  RunWell("tagtwist_simulate",
          {"--config", "room.yaml", "--output", "rec", "--trajectory", "agile", "--height", "1",
           "--duration", "3", "--rate", "20", "--supersampling", "1", "--walls"});
  std::istringstream lines(ReadText(folder_ / "rec/detections.csv"));
  std::string kept;
  for (std::string line; std::getline(lines, line);) {
    const double t_s = line[0] == 't' ? 0 : std::stod(line);
    if (t_s < 1.2 || t_s > 1.8) kept += line + "\n";
  }
  WriteText(folder_ / "rec/detections.csv", kept);
  for (const std::string mode : {"--nosliding_window", "--sliding_window"}) {
    const auto errors = [&](const std::string& tracks) {
      Estimate({"--config", "room.yaml", "--dataset", "rec", "--use_detections", mode, tracks});
      return nlohmann::json::parse(ReadText(folder_ / "out/summary.json"))["accuracy"]["optimised"];
    };
    const auto with = errors("--tracks"), without = errors("--notracks");
    for (const char* key : {"position_rmse_m", "rotation_rmse_rad", "rate_rmse_radps"}) {
      EXPECT_LT(with[key].get<double>(), 0.8 * without[key].get<double>()) << mode << key;
    }
  }
}

}  // namespace
}  // namespace tagtwist::internal::formats_program_test
