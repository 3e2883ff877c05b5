// An IMU where no tag is seen: EuRoC's calibration recording with its tags hidden now and then.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <optional>

#include "frontend/io/tables/csv.h"
#include "tests/support/estimate_program.h"

namespace tagtwist::internal::real_data_imu_test {
namespace {

const std::string kEuroc = std::string(TAGTWIST_REAL_DATA_DIR) + "/euroc-april";
constexpr double kPeriodS = 5, kGapS = 1;

bool IsHidden(double since_start_s) {
  return std::fmod(since_start_s, kPeriodS) >= kPeriodS - kGapS;
}

class RealDataImu : public EstimateProgram {
 protected:
  void SetUp() override {
    if (!fs::exists(kEuroc)) GTEST_SKIP() << "no real data at " << kEuroc;
    fs::create_directory(Path("hidden"));
    for (const char* name : {"timestamps.csv", "imu.csv"}) {
      fs::copy_file(kEuroc + "/cam0/" + name, Path("hidden") / name);
    }
    std::ifstream all(kEuroc + "/cam0/detections.csv");
    std::ofstream seen(Path("hidden") / "detections.csv");
    std::string line;
    std::getline(all, line);
    seen << line << "\n";
    std::optional<double> start;
    while (std::getline(all, line)) {
      const double t_s = std::stod(line);
      if (!start) start = t_s;
      if (!IsHidden(t_s - *start)) seen << line << "\n";
    }
  }
  void RunInto(const std::string& output, const std::string& dataset, bool with_imu) {
    Arguments arguments = {"--dataset",        dataset,     "--config", kEuroc + "/cam0.yaml",
                           "--use_detections", "--notracks"};
    if (with_imu) arguments.emplace_back("--imu");
    Estimate(output, arguments);
  }
  // RMS distance of the states within the gaps [m].
  double ApartInGaps(const std::string& a, const std::string& b) {
    const auto one = CsvTable::Read(Path(a) / "states.csv"),
               other = CsvTable::Read(Path(b) / "states.csv");
    EXPECT_TRUE(one && other);
    const auto at = one->RequireColumns({"t", "x", "y", "z"});
    double sum = 0;
    int n = 0;
    for (size_t i = 0; i < one->rows(); ++i) {
      if (!IsHidden(*one->Number(i, (*at)[0]) - *one->Number(0, (*at)[0]))) continue;
      for (size_t k = 1; k < 4; ++k) {
        sum += std::pow(*one->Number(i, (*at)[k]) - *other->Number(i, (*at)[k]), 2);
      }
      ++n;
    }
    EXPECT_GT(n, 100);
    return std::sqrt(sum / n);
  }
};

TEST_F(RealDataImu, CarriesEurocThroughGaps) {
  RunInto("whole", kEuroc + "/cam0", true);
  RunInto("with", "hidden", true);
  RunInto("without", "hidden", false);
  const double with_m = ApartInGaps("whole", "with"), without_m = ApartInGaps("whole", "without");
  std::cout << "within gaps of 1 s: " << 1e3 * with_m << " mm with the IMU, " << 1e3 * without_m
            << " mm without\n";
  EXPECT_LT(with_m, 0.015);
  EXPECT_GT(without_m, 0.1);
}

}  // namespace
}  // namespace tagtwist::internal::real_data_imu_test
