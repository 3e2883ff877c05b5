// Pictures of a Kalibr board, seconds apart and from anywhere, as a motion capture's calibration
// takes them: nothing ties one to the next.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "frontend/base/statistics/random_stream.h"
#include "frontend/io/tables/csv.h"
#include "frontend/simulation/renderer.h"
#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::stills_program_test {
namespace {

constexpr const char* kChain = R"(cam0:
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 2.0e-04, -3.0e-04]
  distortion_model: radtan
  intrinsics: [380.0, 381.0, 322.0, 236.0]
  resolution: [640, 480]
)";
constexpr const char* kGrid =
    "{target_type: aprilgrid, tagCols: 6, tagRows: 6, tagSize: 0.088, tagSpacing: 0.3}\n";

Camera ChainCamera() {
  Camera out;
  out.width = 640, out.height = 480, out.fx = 380, out.fy = 381, out.cx = 322, out.cy = 236;
  out.k1 = -0.28, out.k2 = 0.07, out.p1 = 2e-4, out.p2 = -3e-4;
  return out;
}

TagMap Board() {
  std::vector<Tag> tags;
  for (int i = 0; i < 36; ++i) {
    const Eigen::Vector3d centre(0.044 + 0.1144 * (i % 6), 0.044 + 0.1144 * (i / 6), 0);
    tags.push_back({i, MakePose(Eigen::Quaterniond::Identity(), centre), 0.088});
  }
  return TagMap("tag36h11b2", tags);
}

// Looks at a point on the board from 0.45 to 1.3 m, tilted by up to 50 degrees and turned anyhow.
Pose DrawView(RandomStream* random) {
  const double y = random->Uniform(0.1, 0.55), x = random->Uniform(0.1, 0.55);
  const Eigen::Vector3d target(x, y, 0);
  const double distance_m = random->Uniform(0.45, 1.3);
  const double roll = random->Uniform(-3.1, 3.1), tilt = random->Uniform(0, 0.87);
  const Eigen::Quaterniond world_from_cam =
      Eigen::AngleAxisd(random->Uniform(-3.1, 3.1), Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(M_PI + tilt, Eigen::Vector3d::UnitX()) *
      Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
  return MakePose(world_from_cam,
                  target - distance_m * (world_from_cam * Eigen::Vector3d::UnitZ()));
}

class SlowStills : public testing::Test {
 protected:
  void SetUp() override {
    WriteText(folder_ / "chain.yaml", kChain);
    WriteText(folder_ / "grid.yaml", kGrid);
    RendererOptions look;
    look.supersampling = 2;
    look.scene.scribbles_per_m2 = 0;
    const auto renderer = Renderer::Make(ChainCamera(), Board(), look);
    ASSERT_TRUE(renderer) << renderer.error().message;
    const auto writer = CreateDatasetWriter(folder_ / "rec", DatasetFormat::kFolder);
    ASSERT_TRUE(writer) << writer.error().message;
    RandomStream random(7);
    int64_t t_ns = 0;
    for (uint64_t i = 0; i < 12; ++i) {
      t_ns += static_cast<int64_t>(1e9 * random.Uniform(1, 5));
      truth_.push_back({t_ns, DrawView(&random), {}});
      FrameToWrite frame;
      frame.t_ns = t_ns;
      frame.image = renderer->Render({truth_.back().world_from_body}, 0, i);
      ASSERT_TRUE((*writer)->Add(frame));
    }
    ASSERT_TRUE((*writer)->Finish(truth_, {}));
  }

  void ExpectEveryPose(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"--camera_file", "chain.yaml", "--map",    "grid.yaml",
                                          "--dataset",     "rec",        "--output", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = RunProgram(folder_.path(), "tagtwist_estimate", arguments);
    ASSERT_EQ(run.status, 0) << run.err;
    const auto states = CsvTable::Read(folder_ / "out/states.csv");
    ASSERT_TRUE(states) << states.error().message;
    ASSERT_EQ(states->rows(), truth_.size());
    const auto column = [&](const char* name) { return *states->FindColumn(name); };
    const auto value = [&](size_t row, const char* name) {
      const auto number = states->Number(row, column(name));
      return number ? *number : NAN;
    };
    for (size_t row = 0; row < truth_.size(); ++row) {
      EXPECT_EQ(states->Cell(row, column("status")), "ok") << row;
      const Pose& truth = truth_[row].world_from_body;
      for (const std::string of : {"", "cf_"}) {
        const auto at = [&](const char* name) { return value(row, (of + name).c_str()); };
        const Eigen::Vector3d position(at("x"), at("y"), at("z"));
        const Eigen::Quaterniond rotation(at("qw"), at("qx"), at("qy"), at("qz"));
        EXPECT_LT((position - truth.translation()).norm(), 5e-4) << of << row;
        EXPECT_LT(rotation.angularDistance(truth.rotation()), 5e-4) << of << row;
      }
      EXPECT_LT(value(row, "sigma_x"), 0.003) << row;
    }
  }

  TempFolder folder_;
  std::vector<TruthSample> truth_;
};

TEST_F(SlowStills, EachHasItsPoseInBatch) { ExpectEveryPose({}); }
TEST_F(SlowStills, EachHasItsPoseInTheWindow) { ExpectEveryPose({"--sliding_window"}); }

}  // namespace
}  // namespace tagtwist::internal::stills_program_test
