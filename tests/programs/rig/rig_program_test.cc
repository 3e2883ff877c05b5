#include <gmock/gmock.h>

#include <string>

#include "tests/support/estimate_program.h"

namespace tagtwist::internal::rig_program_test {
namespace {

using testing::HasSubstr;

// The course's camera under the body, one that takes its frames with it, and one of another clock.
constexpr const char* kRig = R"(
cameras:
  - name: down
    camera: {width: 376, height: 240, fx: 311.05, fy: 311.39, cx: 201.87, cy: 113.62}
    cam_from_body:
      rotation: [0.70710678, -0.70710678, 0, -0.70710678, -0.70710678, 0, 0, 0, -1]
      translation_m: [-0.04, 0, -0.03]
  - name: ahead
    camera: {width: 376, height: 240, fx: 250, fy: 250, cx: 190, cy: 118}
    cam_from_body:
      rotation: [0.70710678, -0.70710678, 0, -0.66446302, -0.66446302, -0.34202014, 0.24184476, 0.24184476, -0.93969262]
      translation_m: [0.02, 0.05, 0]
  - name: free
    camera: {width: 376, height: 240, fx: 280, fy: 280, cx: 190, cy: 118}
    clock_offset_s: 0.007
    recording: third/free
    cam_from_body:
      rotation: [0.70710678, -0.70710678, 0, -0.66446302, -0.66446302, 0.34202014, -0.24184476, -0.24184476, -0.93969262]
      translation_m: [0.02, -0.05, 0]
)";

class RigProgram : public EstimateProgram {
 protected:
  void SetUp() override {
    WriteText(Path("rig.yaml"), kRig);
    Simulate("flight", {"--config", "rig.yaml", "--images=false", "--duration", "6", "--rate", "30",
                        "--corner_noise_px", "0.2"});
  }

  nlohmann::json EstimateRig(const std::string& output, Arguments more = {}) {
    more.insert(more.end(), {"--dataset", "flight", "--config", "rig.yaml", "--use_detections"});
    return Estimate(output, more);
  }
};

TEST_F(RigProgram, SlowThreeCamerasOfTwoClocksAreOneEstimate) {
  EXPECT_TRUE(fs::exists(Path("flight/third/free/detections.csv")));
  for (const bool window : {false, true}) {
    const nlohmann::json summary =
        EstimateRig("results", window ? Arguments{"--sliding_window"} : Arguments{});
    ASSERT_EQ(summary["cameras"].size(), 3U);
    const size_t down = summary["cameras"][0]["frames"], free = summary["cameras"][2]["frames"];
    EXPECT_EQ(summary["cameras"][2]["name"], "free");
    EXPECT_EQ(summary["frames"], down + free);  // the second's are those of the first
    const char* rows = window ? "optimised_lagged" : "optimised";
    const double nees = summary["accuracy"][rows]["nees"]["per_dof"];
    EXPECT_GT(nees, 0.3) << rows;
    EXPECT_LT(nees, 1.8) << rows;
    EXPECT_LT(summary["accuracy"][rows]["position_rmse_m"], 0.003) << rows;
  }
}

// Images of all of them: found where the window expects them, in a batch from image to image.
TEST_F(RigProgram, SlowImagesOfEachCameraAreMeasured) {
  Simulate("film", {"--config", "rig.yaml", "--images", "--supersampling", "1", "--exposure_ms",
                    "0", "--duration", "1", "--rate", "16"});
  for (const bool window : {false, true}) {
    Arguments arguments = {"--dataset", "film", "--config", "rig.yaml"};
    if (window) arguments.insert(arguments.end(), {"--sliding_window", "--detection", "guided"});
    const nlohmann::json summary = Estimate("results", arguments);
    EXPECT_EQ(summary["frames"], summary["frames_estimated"]);
    for (const auto& camera : summary["cameras"]) {
      EXPECT_GT(camera["frames"], 13) << camera;
      EXPECT_GT(camera["tags_used"], 60) << camera;
    }
    EXPECT_LT(summary["accuracy"]["optimised"]["position_rmse_m"], 0.002);
  }
}

TEST_F(RigProgram, SlowEachCamerasClockIsTakenAsTheConfigurationSays) {
  const auto rmse_m = [](const nlohmann::json& summary) {
    return summary["accuracy"]["optimised"]["position_rmse_m"].get<double>();
  };
  const double right_m = rmse_m(EstimateRig("right"));
  std::string text = ReadText(Path("rig.yaml"));
  text.replace(text.find("0.007"), 5, "0.027");
  WriteText(Path("rig.yaml"), text);
  EXPECT_GT(rmse_m(EstimateRig("off")), 2 * right_m);
}

// As Kalibr writes it: the second camera goes by the first.
TEST_F(RigProgram, ACamchainNeedsNoConfiguration) {
  const std::string lens =
      ":\n  camera_model: pinhole\n  intrinsics: [311, 311, 187, 119]\n  distortion_model: radtan\n"
      "  distortion_coeffs: [-0.2, 0.05, 0, 0]\n  resolution: [376, 240]\n";
  WriteText(Path("chain.yaml"),
            "cam0" + lens +
                "  T_cam_imu: [[0.70710678, -0.70710678, 0, -0.04], [-0.70710678, -0.70710678, 0, "
                "0], [0, 0, -1, -0.03], [0, 0, 0, 1]]\ncam1" +
                lens +
                "  T_cn_cnm1:\n  - [1, 0, 0, -0.1]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n"
                "  - [0, 0, 0, 1]\n");
  WriteText(Path("mat.yaml"),
            "tag_map: {grid: {rows: 12, columns: 9, tag_size_m: 0.152, row_gaps_m: 0.152, "
            "column_gaps_m: 0.152}}\n");
  const Arguments of_all = {"--camera_file", "chain.yaml", "--camera", "all", "--map", "mat.yaml"};
  Arguments simulate = of_all;
  simulate.insert(simulate.end(),
                  {"--images=false", "--duration", "3", "--corner_noise_px", "0.2"});
  Simulate("stereo", simulate);
  Arguments arguments = of_all;
  arguments.insert(arguments.end(), {"--dataset", "stereo", "--use_detections"});
  const nlohmann::json summary = Estimate("results", arguments);
  ASSERT_EQ(summary["cameras"].size(), 2U);
  EXPECT_EQ(summary["cameras"][1]["name"], "cam1");
  EXPECT_EQ(summary["cameras"][1]["frames"], summary["frames"]);
  EXPECT_LT(summary["accuracy"]["optimised"]["position_rmse_m"], 0.003);

  WriteText(Path("rig.yaml"), "cameras: {file: chain.yaml, names: [cam0, cam1]}\n");
  Estimate("again", {"--dataset", "stereo", "--use_detections", "--config", "rig.yaml", "--map",
                     "mat.yaml"});
  EXPECT_EQ(ReadText(Path("again/states.csv")), ReadText(Path("results/states.csv")));
}

// Mounts that nobody has measured, and a clock: the configuration that is written is as good as the
// true one, and a second run leaves it so.
TEST_F(RigProgram, SlowCalibratesMountsAndClocks) {
  const auto rmse_m = [](const nlohmann::json& summary) {
    return summary["accuracy"]["optimised"]["position_rmse_m"].get<double>();
  };
  const double right_m = rmse_m(EstimateRig("right"));
  std::string text = ReadText(Path("rig.yaml"));
  const auto replace = [&](const std::string& was, const std::string& is) {
    ASSERT_NE(text.find(was), std::string::npos);
    text.replace(text.find(was), was.size(), is);
  };
  replace("[0.02, 0.05, 0]", "[0, 0, 0]");
  replace("[0.02, -0.05, 0]", "[0.1, 0.1, 0.1]");
  replace("0.007", "0.0");
  WriteText(Path("rig.yaml"), text);
  const nlohmann::json found = EstimateRig("found", {"--calibrate"});
  const auto& cameras = found["calibration"]["cameras"];
  ASSERT_EQ(cameras.size(), 2U);
  EXPECT_EQ(cameras[1]["name"], "free");
  EXPECT_NEAR(cameras[1]["clock_s"].get<double>(), 0.007, 3e-4);
  EXPECT_EQ(cameras[0]["clock_is_taken"], false);
  EXPECT_LT(rmse_m(found), 1.2 * right_m);
  ASSERT_TRUE(fs::exists(Path("found/calibration.yaml")));
  const nlohmann::json again =
      Estimate("again", {"--dataset", "flight", "--config", "found/calibration.yaml",
                         "--use_detections", "--calibrate"});
  EXPECT_LT(rmse_m(again), 1.2 * right_m);
  for (const auto& camera : again["calibration"]["cameras"]) {
    for (int a = 0; a < 3; ++a) {
      EXPECT_LT(std::abs(camera["mount_shift_m"][a].get<double>()),
                0.5 * camera["mount_shift_sigma_m"][a].get<double>());
    }
  }
}

TEST_F(RigProgram, WhatIsOfOneCameraIsRefused) {
  for (const char* flag : {"--map_unknown_tags", "--write_detections"}) {
    const ProgramRun run =
        RunProgram(folder_.path(), "tagtwist_estimate",
                   {"--dataset", "flight", "--config", "rig.yaml", "--use_detections", flag});
    EXPECT_EQ(run.status, 1) << flag;
    EXPECT_THAT(run.err, HasSubstr(std::string(flag) + " is of one camera")) << flag;
    EXPECT_TRUE(IsOneLine(run.err)) << run.err;
  }
}

}  // namespace
}  // namespace tagtwist::internal::rig_program_test
