#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/estimate_program.h"

namespace tagtwist::internal::imu_program_test {
namespace {

using ::testing::HasSubstr;

class ImuProgram : public EstimateProgram {
 protected:
  void ExpectRefused(Arguments arguments, int status, const char* fault) {
    arguments.insert(arguments.end(), {"--output", "refused"});
    const ProgramRun run = RunProgram(folder_.path(), "tagtwist_estimate", arguments);
    EXPECT_EQ(run.status, status) << run.err;
    EXPECT_THAT(run.err, HasSubstr(fault));
    EXPECT_TRUE(HasNoResults(folder_ / "refused"));
  }
};

// A flight without tags for a while: the summary tells what the IMU is, and the gap is bridged.
TEST_F(ImuProgram, IsInTheEstimateWhereAsked) {
  Simulate("flight", {"--images=false", "--duration", "6", "--rate", "30", "--trajectory", "agile",
                      "--gyro_bias_radps", "0.02", "--accel_bias_mps2", "0.2", "--hide_tags_from",
                      "2", "--hide_tags_to", "3.2"});
  const Arguments batch = {"--dataset", "flight", "--use_detections", "--tracks=false"};
  Arguments with_imu = batch;
  with_imu.emplace_back("--imu");
  const auto without = Estimate("without", batch), with = Estimate("with", with_imu);
  EXPECT_FALSE(without.contains("imu"));
  const auto& imu = with["imu"];
  EXPECT_NEAR(imu["gravity_world_mps2"][2].get<double>(), -9.81, 0.01);
  EXPECT_NEAR(imu["time_offset_s"].get<double>(), 0, 1e-3);
  EXPECT_GT(imu["gyro_bias_sigma_radps"][0].get<double>(), 0);
  EXPECT_LT(with["accuracy"]["optimised"]["position_rmse_m"].get<double>(),
            0.5 * without["accuracy"]["optimised"]["position_rmse_m"].get<double>());
  EXPECT_EQ(with["frames"], with["frames_estimated"]);
}

// Kalibr's imu.yaml and EuRoC's sensor.yaml, by the section's key file.
TEST_F(ImuProgram, TakesTheFilesOfOthers) {
  Simulate("flight", {"--images=false", "--duration", "3", "--rate", "30"});
  const std::string densities =
      "gyroscope_noise_density: 0.000707\naccelerometer_noise_density: 0.00707\n"
      "gyroscope_random_walk: 1e-5\naccelerometer_random_walk: 1e-4\nupdate_rate: 200.0\n";
  const std::string identity = "data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]";
  WriteText(folder_ / "imu.yaml", "rostopic: /imu\n" + densities);
  WriteText(folder_ / "sensor.yaml",
            "sensor_type: imu\nT_BS:\n  cols: 4\n  rows: 4\n  " + identity + "\n" + densities);
  WriteText(
      folder_ / "turned.yaml",
      densities + "T_i_b:\n- [0, 1, 0, 0]\n- [-1, 0, 0, 0]\n- [0, 0, 1, 0]\n- [0, 0, 0, 1]\n");
  WriteText(folder_ / "camera.yaml", "cam0: {resolution: [752, 480]}\n");
  const auto configured = [&](const std::string& section) {
    WriteText(folder_ / "config.yaml", "imu: {" + section + "}\n");
    return Arguments{"--dataset",   "flight", "--use_detections", "--tracks=false", "--config",
                     "config.yaml", "--imu"};
  };
  for (const char* file : {"imu.yaml", "sensor.yaml"}) {
    const auto summary =
        Estimate("out", configured("file: " + std::string(file) + ", learn_noise: false"));
    EXPECT_DOUBLE_EQ(summary["imu"]["gyroscope_noise_density"].get<double>(), 0.000707) << file;
  }
  const auto own = Estimate(
      "own", configured("file: imu.yaml, learn_noise: false, gyroscope_noise_density: 0.001"));
  EXPECT_DOUBLE_EQ(own["imu"]["gyroscope_noise_density"].get<double>(), 0.001);
  // The recording's IMU is not turned: what is wrong is told with what would fit.
  const auto turned = Estimate("turned", configured("file: turned.yaml"));
  EXPECT_NE(turned["imu"]["left_out"].dump().find("axes"), std::string::npos) << turned["imu"];
  EXPECT_NE(turned["warnings"].dump().find("imu.body_from_imu would have quaternion_xyzw"),
            std::string::npos)
      << turned["warnings"];
  const std::string back =
      "body_from_imu: {quaternion_xyzw: [0, 0, 0, 1], translation_m: [0, 0, 0]}";
  EXPECT_GT(Estimate("back", configured("file: turned.yaml, " + back))["imu"]["intervals"], 0);
  ExpectRefused(configured("body_from_imu: {translation_m: [0, 0, 0]}"), 1,
                "imu.body_from_imu: expected rotation or quaternion_xyzw");
  ExpectRefused(configured("file: camera.yaml"), 1, "camera.yaml: expected an IMU's");
  ExpectRefused(configured("file: none.yaml"), 1, "none.yaml");
}

TEST_F(ImuProgram, IsInTheWindowOfARecordingPlayedAsIfLive) {
  Simulate("flight", {"--images=false", "--duration", "2", "--rate", "30"});
  const auto played =
      Estimate("played", {"--dataset", "flight", "--use_detections", "--tracks=false",
                          "--sliding_window", "--realtime", "--imu"});
  EXPECT_TRUE(played.contains("live"));
  EXPECT_GT(played["imu"]["intervals"], 10);
  EXPECT_THAT(ReadText(folder_ / "played/report.html"), HasSubstr("<h2>IMU</h2>"));
}

TEST_F(ImuProgram, RefusesWhatItCannotTake) {
  Simulate("bare", {"--images=false", "--duration", "2", "--imu_rate", "0"});
  const Arguments batch = {"--dataset", "bare", "--use_detections", "--tracks=false", "--imu"};
  ExpectRefused(batch, 1, "bare: has no IMU, and one is asked for");
  WriteText(folder_ / "wrong.yaml", "imu: {gyroscope_noise_density: 0}\n");
  Arguments wrong = batch;
  wrong.insert(wrong.end(), {"--config", "wrong.yaml"});
  ExpectRefused(wrong, 1, "wrong.yaml:1: imu.gyroscope_noise_density: expected");
}

}  // namespace
}  // namespace tagtwist::internal::imu_program_test
