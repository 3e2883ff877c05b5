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

TEST_F(ImuProgram, RefusesWhatItCannotTake) {
  Simulate("bare", {"--images=false", "--duration", "2", "--imu_rate", "0"});
  const Arguments batch = {"--dataset", "bare", "--use_detections", "--tracks=false", "--imu"};
  ExpectRefused(batch, 1, "bare: has no IMU, and --imu asks for one");
  WriteText(folder_ / "wrong.yaml", "imu: {gyroscope_noise_density: 0}\n");
  Arguments wrong = batch;
  wrong.insert(wrong.end(), {"--config", "wrong.yaml"});
  ExpectRefused(wrong, 1, "wrong.yaml:1: imu.gyroscope_noise_density: expected");
}

}  // namespace
}  // namespace tagtwist::internal::imu_program_test
