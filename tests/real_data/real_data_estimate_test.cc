// tagtwist_estimate on real recordings, and on flights along real paths.
#include <gtest/gtest.h>

#include <cmath>

#include "frontend/io/tables/csv.h"
#include "tests/support/estimate_program.h"

namespace tagtwist::internal::real_data_estimate_test {
namespace {

const std::string kRealData = TAGTWIST_REAL_DATA_DIR;
const std::string kSource = TAGTWIST_SOURCE_DIR;

// Flights along the real Vicon paths at the real image times; corners with noise, no images.
class RealDataVicon : public EstimateProgram, public testing::WithParamInterface<std::string> {
 protected:
  void SetUp() override {
    if (!fs::exists(kRealData)) GTEST_SKIP() << "no real data at " << kRealData;
    const std::string course = kRealData + "/course/";
    Simulate("flight",
             {"--trajectory", course + "vicon_dataset" + GetParam() + ".csv", "--image_times",
              course + "image_times_dataset" + GetParam() + ".csv", "--images=false"});
  }
};

TEST_P(RealDataVicon, BatchAndWindowAgainstTheClosedForm) {
  const auto batch = Estimate("batch", {"--dataset", "flight", "--use_detections"});
  EXPECT_LT(Ratio(batch, "position_rmse_m"), 0.6);
  EXPECT_LT(Ratio(batch, "velocity_rmse_mps"), 0.25);
  const auto window =
      Estimate("window", {"--dataset", "flight", "--use_detections", "--sliding_window"});
  EXPECT_LT(Ratio(window, "velocity_rmse_mps"), 0.5);
  const auto against_batch = [&](const char* key) {
    return window["accuracy"]["optimised_lagged"][key].get<double>() /
           batch["accuracy"]["optimised"][key].get<double>();
  };
  EXPECT_LT(against_batch("position_rmse_m"), 1.15);
  EXPECT_LT(against_batch("velocity_rmse_mps"), 1.25);
}
INSTANTIATE_TEST_SUITE_P(Trials, RealDataVicon, testing::Values("1", "4"));

class RealDataFrames : public EstimateProgram {
 protected:
  void SetUp() override {
    if (!fs::exists(kRealData)) GTEST_SKIP() << "no real data at " << kRealData;
  }
};

TEST_F(RealDataFrames, Trial4LiesNearVicon) {
  const auto summary = Estimate("out", {"--dataset", kRealData + "/course-dataset4-frames",
                                        "--config", kSource + "/configs/course_2017.yaml"});
  EXPECT_EQ(summary["frames_estimated"].get<int>(), 61);
  EXPECT_LE(summary["accuracy"]["optimised"]["position_median_m"].get<double>(), 0.015);
  EXPECT_LT(Ratio(summary, "position_rmse_m"), 1.0);
}

// Body rates against the gyro: RMS of the 3-D difference [rad/s] over frames with a sample nearby.
double RateDifferenceToGyro(const std::string& states_path, const std::string& imu_path) {
  const auto states = CsvTable::Read(states_path), imu = CsvTable::Read(imu_path);
  EXPECT_TRUE(states && imu);
  const auto s = states->RequireColumns({"t", "wx_body", "wy_body", "wz_body"});
  const auto g = imu->RequireColumns({"t", "gx", "gy", "gz"});
  double sum = 0;
  int n = 0;
  for (size_t i = 0; i < states->rows(); ++i) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    int samples = 0;
    for (size_t k = 0; k < imu->rows(); ++k) {
      if (std::abs(*imu->Number(k, (*g)[0]) - *states->Number(i, (*s)[0])) > 0.02) continue;
      mean += Eigen::Vector3d(*imu->Number(k, (*g)[1]), *imu->Number(k, (*g)[2]),
                              *imu->Number(k, (*g)[3]));
      ++samples;
    }
    if (samples == 0) continue;
    const Eigen::Vector3d rate(*states->Number(i, (*s)[1]), *states->Number(i, (*s)[2]),
                               *states->Number(i, (*s)[3]));
    sum += (rate - mean / samples).squaredNorm();
    ++n;
  }
  EXPECT_GT(n, 100);
  return std::sqrt(sum / n);
}

// The dataset's own mount of the IMU is within three sigmas; its samples arrive in bursts, so few
// turns between frames can be used.
TEST_F(RealDataFrames, FloorMatTellsWhereItsGyroSits) {
  const auto summary = Estimate("out", {"--dataset", kRealData + "/umd-floor-mat", "--config",
                                        kSource + "/tests/configs/umd_floor_mat.yaml",
                                        "--use_detections", "--notracks", "--calibrate"});
  const auto& gyro = summary["gyro"];
  const auto q = gyro["cam_from_imu_xyzw"].get<std::vector<double>>();
  const Eigen::Quaterniond found(q[3], q[0], q[1], q[2]);
  const Eigen::Quaterniond given(0.496944160668265, -0.5126603701935, 0.488237012471085,
                                 0.501847054055403);
  double variance = 0;
  for (const double sigma : gyro["rotation_sigma_rad"]) variance += sigma * sigma;
  EXPECT_LT(found.angularDistance(given), 3 * std::sqrt(variance));
  EXPECT_LT(std::sqrt(variance), 0.03);
  EXPECT_LT(std::abs(gyro["time_offset_s"].get<double>()), 0.02);
}

TEST_F(RealDataFrames, FloorMatIsConsistentWithItselfAndWithTheGyro) {
  const auto summary = Estimate(
      "out", {"--dataset", kRealData + "/umd-floor-mat", "--config",
              kSource + "/tests/configs/umd_floor_mat.yaml", "--use_detections", "--notracks"});
  EXPECT_EQ(summary["frames_estimated"].get<int>(), 450);
  EXPECT_LE(summary["reprojection_px"]["median"].get<double>(), 0.5);
  EXPECT_LE(RateDifferenceToGyro(Path("out") / "states.csv", kRealData + "/umd-floor-mat/imu.csv"),
            0.08);
}

}  // namespace
}  // namespace tagtwist::internal::real_data_estimate_test
