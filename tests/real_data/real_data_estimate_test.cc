// tagtwist_estimate on real recordings, and on flights along real paths.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

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

// Body rates against the gyro, over frames with samples within so much of them: RMS of the 3-D
// difference [rad/s], and its NEES per degree of freedom; where the gyro has a bias, without it.
struct AgainstGyro {
  double rms_radps = 0, nees = 0;
};

AgainstGyro RatesAgainstGyro(const std::string& states_path, const std::string& imu_path,
                             double within_s, bool has_bias) {
  const auto states = CsvTable::Read(states_path), imu = CsvTable::Read(imu_path);
  EXPECT_TRUE(states && imu);
  const auto s = states->RequireColumns(
      {"t", "wx_body", "wy_body", "wz_body", "sigma_wx", "sigma_wy", "sigma_wz"});
  const auto g = imu->RequireColumns({"t", "gx", "gy", "gz"});
  const auto vector = [](const CsvTable& table, size_t row, const std::vector<size_t>& columns,
                         size_t first) {
    return Eigen::Array3d(*table.Number(row, columns[first]),
                          *table.Number(row, columns[first + 1]),
                          *table.Number(row, columns[first + 2]));
  };
  std::vector<double> times_s;
  for (size_t k = 0; k < imu->rows(); ++k) times_s.push_back(*imu->Number(k, (*g)[0]));
  std::vector<Eigen::Array3d> errors, sigmas;
  for (size_t i = 0; i < states->rows(); ++i) {
    const double t_s = *states->Number(i, (*s)[0]);
    Eigen::Array3d sum = Eigen::Array3d::Zero();
    int samples = 0;
    for (size_t k = 0; k < times_s.size(); ++k) {
      if (std::abs(times_s[k] - t_s) > within_s) continue;
      sum += vector(*imu, k, *g, 1);
      ++samples;
    }
    if (samples == 0) continue;
    errors.push_back(vector(*states, i, *s, 1) - sum / samples);
    sigmas.push_back(vector(*states, i, *s, 4));
  }
  const auto n = static_cast<double>(errors.size());
  EXPECT_GT(n, 100);
  Eigen::Array3d bias = Eigen::Array3d::Zero();
  if (has_bias) {
    for (const auto& error : errors) bias += error / n;
  }
  AgainstGyro out;
  for (size_t i = 0; i < errors.size(); ++i) {
    const Eigen::Array3d error = errors[i] - bias;
    out.rms_radps += error.square().sum() / n;
    out.nees += (error / sigmas[i]).square().mean() / n;
  }
  out.rms_radps = std::sqrt(out.rms_radps);
  return out;
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
  EXPECT_LE(RatesAgainstGyro(Path("out") / "states.csv", kRealData + "/umd-floor-mat/imu.csv", 0.02,
                             /*has_bias=*/false)
                .rms_radps,
            0.08);
}

// Cameras in a hand, which trembles faster than the motion's jerk, as a whole, lets on.
TEST_F(RealDataFrames, RatesOfATremblingHandAreKnownAsWellAsTheySay) {
  const std::string euroc = kRealData + "/euroc-april/", floor = kRealData + "/umd-floor-mat";
  struct Recording {
    std::string folder, config;
    double within_s;  // the floor mat's samples arrive in bursts
    double most_rms_radps, least_nees, most_nees;
  };
  for (const Recording& recording :
       {Recording{euroc + "cam0", euroc + "cam0.yaml", 0.003, 0.065, 0.6, 1.3},
        Recording{euroc + "cam1", euroc + "cam1.yaml", 0.003, 0.065, 0.6, 1.3},
        Recording{floor, kSource + "/tests/configs/umd_floor_mat.yaml", 0.02, 0.08, 0.5, 1.6}}) {
    for (const bool window : {false, true}) {
      std::vector<std::string> arguments = {"--dataset",      recording.folder,   "--config",
                                            recording.config, "--use_detections", "--notracks"};
      if (window) arguments.push_back("--sliding_window");
      Estimate("out", arguments);
      const auto rates =
          RatesAgainstGyro(Path("out") / (window ? "states_lagged.csv" : "states.csv"),
                           recording.folder + "/imu.csv", recording.within_s, /*has_bias=*/true);
      std::printf("%s, %s: rates %.3f rad/s RMS from the gyro's, NEES %.2f\n",
                  recording.folder.c_str(), window ? "at the lag" : "batch", rates.rms_radps,
                  rates.nees);
      EXPECT_LT(rates.rms_radps, recording.most_rms_radps) << recording.folder << window;
      EXPECT_GT(rates.nees, recording.least_nees) << recording.folder << window;
      EXPECT_LT(rates.nees, recording.most_nees) << recording.folder << window;
    }
  }
}

}  // namespace
}  // namespace tagtwist::internal::real_data_estimate_test
