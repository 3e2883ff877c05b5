// Two cameras on one body must agree as well as each says of itself.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <fstream>
#include <map>

#include "frontend/io/tables/csv.h"
#include "frontend/types/body_state.h"
#include "tests/support/estimate_program.h"

namespace tagtwist::internal::real_data_agreement_test {
namespace {

const std::string kCameras = std::string(TAGTWIST_REAL_DATA_DIR) + "/tagslam-four-cameras";

struct PoseAndCovariance {
  Pose world_from_body;
  PoseCovariance covariance;
};
using Poses = std::map<std::string, PoseAndCovariance>;  // by stamp

// Frames with tags of their own, with the pose's block of their covariance.
Poses ReadPoses(const fs::path& folder) {
  const auto states = CsvTable::Read(folder / "states.csv");
  const auto covariances = CsvTable::Read(folder / "covariance.csv");
  EXPECT_TRUE(states && covariances);
  const auto pose = states->RequireColumns({"t", "x", "y", "z", "qx", "qy", "qz", "qw"});
  const auto status = states->RequireColumns({"status"});
  Poses out;
  for (size_t row = 0; row < states->rows(); ++row) {
    if (states->Cell(row, (*status)[0]) != "ok") continue;
    const auto number = [&](size_t k) { return *states->Number(row, (*pose)[k]); };
    PoseAndCovariance& at = out[std::string(states->Cell(row, (*pose)[0]))];
    at.world_from_body =
        MakePose(Eigen::Quaterniond(number(7), number(4), number(5), number(6)).normalized(),
                 {number(1), number(2), number(3)});
    size_t column = 1;  // upper triangle, row by row
    for (int i = 0; i < 12; ++i) {
      for (int j = i; j < 12; ++j, ++column) {
        if (i >= 6 || j >= 6) continue;
        at.covariance(i, j) = at.covariance(j, i) = *covariances->Number(row, column);
      }
    }
  }
  return out;
}

// Per degree of freedom, over the frames that both have.
double PairNees(const Poses& a, const Poses& b) {
  double sum = 0;
  int n = 0;
  for (const auto& [stamp, first] : a) {
    const auto second = b.find(stamp);
    if (second == b.end()) continue;
    const PoseStep error = Difference(second->second.world_from_body, first.world_from_body);
    const PoseCovariance covariance = first.covariance + second->second.covariance;
    sum += error.dot(covariance.llt().solve(error)) / 6;
    ++n;
  }
  EXPECT_GT(n, 500);
  return sum / n;
}

class RealDataAgreement : public EstimateProgram {
 protected:
  void SetUp() override {
    if (!fs::exists(kCameras)) GTEST_SKIP() << "no real data at " << kCameras;
  }
  // One camera alone.
  Poses Of(const std::string& camera, bool systematic) {
    const fs::path config = Path(camera + (systematic ? "_with.yaml" : "_without.yaml"));
    std::string text = ReadText(kCameras + "/" + camera + ".yaml");
    for (const std::string file : {"cameras.yaml", "bodies.yaml"}) {
      text.replace(text.find(file), file.size(), kCameras + "/" + file);
    }
    std::ofstream(config) << text
                          << "estimator: {systematic_errors: " << (systematic ? "true" : "false")
                          << "}\n";
    Run("tagtwist_estimate",
        {"--dataset", kCameras + "/" + camera, "--config", config, "--use_detections",
         "--tracks=false", "--write_covariance", "--output", camera});
    return ReadPoses(Path(camera));
  }
};

// Lenses and map are as published: the cameras lie 15 mm and 15 mrad apart. What lasts of their
// errors is learned from each camera's own residuals, by nothing that another one sees.
TEST_F(RealDataAgreement, CovariancesCoverWhatLensesAndMapErrBy) {
  EXPECT_GT(PairNees(Of("cam0", false), Of("cam1", false)), 20);
  const double nees = PairNees(Of("cam0", true), Of("cam1", true));
  EXPECT_GT(nees, 0.3);
  EXPECT_LT(nees, 4);
}

}  // namespace
}  // namespace tagtwist::internal::real_data_agreement_test
