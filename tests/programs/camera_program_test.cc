// tagtwist_camera as it is run: a camera of which nothing is known, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "frontend/base/format_text.h"
#include "frontend/base/units.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::camera_program_test {
namespace {

using ::testing::HasSubstr;

const char* const kSheet =
    "tag_map:\n  family: tag36h11\n"
    "  grid: {rows: 6, columns: 6, tag_size_m: 0.03, row_gaps_m: 0.01, column_gaps_m: 0.01}\n";
const char* const kCamera =
    "camera: {width: 320, height: 240, fx: 231.7, fy: 230.9, cx: 162.3, cy: 117.8, distortion: "
    "[-0.21, 0.05, 0.0004, -0.0006]}\n"
    "cam_from_body: {rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation_m: [0, 0, 0]}\n";

// A camera that circles over the sheet and looks at it, from up to `tilt_rad` aside.
std::string Way(double tilt_rad) {
  std::string out = "t,x,y,z,qx,qy,qz,qw\n";
  for (int i = 0; i <= 600; ++i) {
    const double t = 0.02 * i, turn = 2 * kPi * t;
    const double tilt = tilt_rad * std::sin(turn / 2.3), azimuth = turn / 7.1;
    const Eigen::Vector3d from(std::sin(tilt) * std::cos(azimuth),
                               std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
    const Eigen::Vector3d target(0.115 + 0.07 * std::sin(turn / 1.7),
                                 0.115 + 0.07 * std::sin(turn / 3.7), 0);
    const Eigen::Vector3d place = target + (0.2 + 0.05 * std::sin(turn / 4.1)) * from;
    const Eigen::Quaterniond attitude =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), from) *
        Eigen::Quaterniond(0, 1, 0, 0) *
        Eigen::AngleAxisd(0.8 * std::sin(turn / 5.3), Eigen::Vector3d::UnitZ());
    out += Format("%.2f,%.6f,%.6f,%.6f,%.9f,%.9f,%.9f,%.9f\n", t, place.x(), place.y(), place.z(),
                  attitude.x(), attitude.y(), attitude.z(), attitude.w());
  }
  return out;
}

class CameraProgram : public testing::Test {
 protected:
  void SetUp() override {
    WriteText(folder_ / "sheet.yaml", kSheet);
    WriteText(folder_ / "truth.yaml", std::string(kCamera) + kSheet);
  }

  ProgramRun Run(const std::string& program, const std::vector<std::string>& arguments) {
    return RunProgram(folder_.path(), program, arguments);
  }
  void Film(double tilt_rad, std::vector<std::string> more) {
    WriteText(folder_ / "way.csv", Way(tilt_rad));
    more.insert(more.end(), {"--output", "film", "--config", "truth.yaml", "--trajectory",
                             "way.csv", "--imu_rate", "0"});
    const ProgramRun made = Run("tagtwist_simulate", more);
    ASSERT_EQ(made.status, 0) << made.err;
  }
  // The sheet's flight with the camera that was found.
  nlohmann::json Estimate(std::vector<std::string> more) {
    more.insert(more.end(), {"--dataset", "film", "--camera_file", "camera.yaml", "--map",
                             "sheet.yaml", "--tracks=false", "--output", "out"});
    const ProgramRun run = Run("tagtwist_estimate", more);
    EXPECT_EQ(run.status, 0) << run.err;
    return nlohmann::json::parse(ReadText(folder_ / "out/summary.json"));
  }

  const TempFolder folder_;
};

const std::vector<std::string> kByCorners = {
    "--from", "film", "--map", "sheet.yaml", "--output", "camera.yaml", "--use_detections"};

TEST_F(CameraProgram, WritesACameraThatTheEstimateTakes) {
  Film(0.8, {"--images=false", "--corner_noise_px", "0.1", "--rate", "20"});
  std::vector<std::string> arguments = kByCorners;
  const ProgramRun no_size = Run("tagtwist_camera", arguments);
  EXPECT_EQ(no_size.status, 1);
  EXPECT_TRUE(IsOneLine(no_size.err)) << no_size.err;
  EXPECT_THAT(no_size.err, HasSubstr("--image_size"));

  arguments.insert(arguments.end(),
                   {"--image_size", "320x240", "--picture", "seen.svg", "--report", "camera.html"});
  ReplaceLine(folder_ / "film/timestamps.csv", 9, "0.0,");  // the clock stepped back
  const ProgramRun run = Run("tagtwist_camera", arguments);
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  EXPECT_THAT(run.err, HasSubstr("tagtwist_camera: warning: film"));
  EXPECT_THAT(run.out, HasSubstr("radtan, 4 coefficients"));
  EXPECT_THAT(run.out, HasSubstr("verdict    good"));
  EXPECT_THAT(ReadText(folder_ / "camera.yaml"), HasSubstr("  # +- "));
  EXPECT_THAT(ReadText(folder_ / "camera.yaml"), HasSubstr("\n  focal_sigma: "));
  EXPECT_THAT(ReadText(folder_ / "camera.yaml"), HasSubstr("\n  principal_point_sigma_px: ["));
  EXPECT_THAT(ReadText(folder_ / "camera.yaml"), HasSubstr("\n  correlations:\n  "));
  EXPECT_THAT(ReadText(folder_ / "seen.svg"), HasSubstr("</svg>"));
  const std::string report = ReadText(folder_ / "camera.html");
  EXPECT_THAT(report, HasSubstr("good: nothing speaks against it"));
  EXPECT_THAT(report, HasSubstr("Where the image was covered"));
  EXPECT_THAT(report, HasSubstr("<title>Corners that the camera saw</title>"));
  EXPECT_THAT(report, HasSubstr("<td>fx [px]</td><td>231."));
  const auto summary = Estimate({"--use_detections"});
  EXPECT_THAT(summary["taken"].dump(),
              HasSubstr("that last, in the covariance: focal length +- 0.0"));
  EXPECT_THAT(summary["taken"].dump(), HasSubstr("camera.yaml (focal length +- 0.0"));
  EXPECT_EQ(summary["frames"], summary["frames_estimated"]);
  EXPECT_LT(summary["reprojection_px"]["median"].get<double>(), 0.2);
}

TEST_F(CameraProgram, SlowLearnsWhereTheTagsOfASheetAre) {
  Film(0.8, {"--images=false", "--corner_noise_px", "0.1", "--rate", "10"});
  std::vector<std::string> arguments = {"--from",   "film",        "--image_size",    "320x240",
                                        "--output", "camera.yaml", "--use_detections"};
  const ProgramRun run = Run("tagtwist_camera", arguments);
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("learned with it: where the 36 tags are"));
  const auto summary = Estimate({"--use_detections"});
  EXPECT_EQ(summary["frames"], summary["frames_estimated"]);
  EXPECT_LT(summary["reprojection_px"]["median"].get<double>(), 0.2);
  const std::string camera = ReadText(folder_ / "camera.yaml");
  EXPECT_NEAR(std::stod(camera.substr(camera.find("\n  fx: ") + 7)) / 231.7, 1, 0.005);

  WriteText(folder_ / "two.yaml",
            "tag_map:\n  family: tag36h11\n  tags:\n"
            "    - {id: 0, size_m: 0.03, position_m: [0.05, 0.05, 0], rotation: [1, 0, 0, 0, 1, 0, "
            "0, 0, 1]}\n"
            "    - {id: 1, size_m: 0.06, position_m: [0.15, 0.1, 0], rotation: [1, 0, 0, 0, 1, 0, "
            "0, 0, 1]}\n");
  WriteText(folder_ / "truth.yaml", std::string(kCamera) + ReadText(folder_ / "two.yaml"));
  std::filesystem::remove_all(folder_ / "film");
  Film(0.8, {"--images=false", "--corner_noise_px", "0.1", "--rate", "10"});
  const ProgramRun sizes = Run("tagtwist_camera", arguments);
  EXPECT_EQ(sizes.status, 1);
  EXPECT_TRUE(IsOneLine(sizes.err)) << sizes.err;
  EXPECT_THAT(sizes.err, HasSubstr("are not of one size on one plane (--map FILE says it"));
}

TEST_F(CameraProgram, RefusesViewsThatTellNothing) {
  Film(0.02, {"--images=false", "--corner_noise_px", "0.1", "--rate", "5"});
  std::vector<std::string> arguments = kByCorners;
  arguments.insert(arguments.end(), {"--image_size", "320x240"});
  const ProgramRun run = Run("tagtwist_camera", arguments);
  EXPECT_EQ(run.status, 1);
  EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  EXPECT_THAT(run.err, HasSubstr("tilt them more"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "camera.yaml"));
}

TEST_F(CameraProgram, SlowWritesAPoorCameraWhereAsked) {
  Film(0.02, {"--images=false", "--corner_noise_px", "0.1", "--rate", "3"});
  std::vector<std::string> arguments = kByCorners;
  arguments.insert(arguments.end(), {"--image_size", "320x240", "--accept_poor"});
  const ProgramRun poor = Run("tagtwist_camera", arguments);
  EXPECT_EQ(poor.status, 0) << poor.err;
  EXPECT_THAT(ReadText(folder_ / "camera.yaml"), HasSubstr("not good: "));
}

TEST_F(CameraProgram, RefusesWrongUsage) {
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {},
           {"--from", "film", "--map", "sheet.yaml"},
           {"--from", "film", "--output", "camera.yaml", "--tag_size_m", "0.03"},
           {"--from", "film", "--map", "sheet.yaml", "--output", "c.yaml", "--image_size", "640"},
           {"--from", "film", "--map", "sheet.yaml", "--output", "c.yaml", "--image_size", "0x2"},
           {"--from", "film", "--map", "s.yaml", "--output", "c.yaml", "--tag_size_m", "-1"},
           {"--from", "film", "--output", "c.yaml", "--page", "x"},
           {"--from", "film", "--output", "c.yaml", "--page", "0", "--use_detections"},
           {"--from", "film", "--output", "c.yaml", "--listen", "0.0.0.0"},
           {"--from", "camera:0", "--map", "s.yaml", "--output", "c.yaml", "--use_detections"}}) {
    const ProgramRun run = Run("tagtwist_camera", arguments);
    EXPECT_EQ(run.status, 2);
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  }
  EXPECT_EQ(
      Run("tagtwist_camera", {"--from", "nowhere", "--map", "sheet.yaml", "--output", "c"}).status,
      1);
  const ProgramRun none = Run(
      "tagtwist_camera", {"--from", "camera:nowhere", "--map", "sheet.yaml", "--output", "c.yaml"});
  EXPECT_EQ(none.status, 1);
  EXPECT_TRUE(IsOneLine(none.err)) << none.err;
  const ProgramRun kept =
      Run("tagtwist_camera", {"--from", "film", "--map", "sheet.yaml", "--output", "sheet.yaml"});
  EXPECT_EQ(kept.status, 1);
  EXPECT_EQ(ReadText(folder_ / "sheet.yaml"), kSheet);
}

TEST_F(CameraProgram, SlowFindsTheLensOfImages) {
  Film(0.8, {"--rate", "4", "--supersampling", "3", "--scribble", "0", "--noise", "2"});
  const ProgramRun run =
      Run("tagtwist_camera", {"--from", "film", "--map", "sheet.yaml", "--output", "camera.yaml"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("radtan, 4 coefficients"));
  const auto summary = Estimate({});
  EXPECT_EQ(summary["frames"], summary["frames_estimated"]);
  EXPECT_LT(summary["accuracy"]["optimised"]["position_rmse_m"].get<double>(), 5e-4);

  // The images as a camera that says what it still wants.
  const ProgramRun live = Run("tagtwist_camera", {"--from", "camera:film/images/%06d.png", "--map",
                                                  "sheet.yaml", "--output", "live.yaml"});
  EXPECT_EQ(live.status, 0) << live.err;
  EXPECT_THAT(live.out, HasSubstr("show the tags"));
  EXPECT_THAT(live.out, HasSubstr("views differ, expected 10"));
  EXPECT_THAT(live.out, HasSubstr("calibrating\n"));
  EXPECT_THAT(live.out, HasSubstr("verdict    good"));
}

// A real lens from nothing is at least as good as the one that was published with the recording.
TEST_F(CameraProgram, RealDataEurocFromNothingIsAsGoodAsThePublishedLens) {
  const std::string data = std::string(TAGTWIST_REAL_DATA_DIR) + "/euroc-april/";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << data << " is not there";
  const ProgramRun run =
      Run("tagtwist_camera", {"--from", data + "cam0", "--use_detections", "--image_size",
                              "752x480", "--map", data + "april_6x6.yaml", "--output", "c.yaml"});
  ASSERT_EQ(run.status, 0) << run.err;
  const auto median_px = [&](const std::vector<std::string>& camera) {
    std::vector<std::string> arguments = {
        "--dataset",        data + "cam0",    "--map",    data + "april_6x6.yaml",
        "--use_detections", "--tracks=false", "--output", "out"};
    arguments.insert(arguments.end(), camera.begin(), camera.end());
    const ProgramRun estimate = Run("tagtwist_estimate", arguments);
    EXPECT_EQ(estimate.status, 0) << estimate.err;
    const auto summary = nlohmann::json::parse(ReadText(folder_ / "out/summary.json"));
    return summary["reprojection_px"]["median"].get<double>();
  };
  EXPECT_LT(median_px({"--camera_file", "c.yaml"}),
            median_px({"--camera_file", data + "camchain.yaml", "--camera", "cam0"}));
}

}  // namespace
}  // namespace tagtwist::internal::camera_program_test
