// A flight through each lens model that other calibrations have, rendered and as corners.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/program_test_util.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal::lenses_program_test {
namespace {

struct Lens {
  const char* name;
  const char* camera;
};
void PrintTo(const Lens& lens, std::ostream* out) { *out << lens.name; }

class LensesProgram : public testing::TestWithParam<Lens> {
 protected:
  void SetUp() override {
    WriteText(folder_ / "c.yaml",
              std::string("camera: {width: 376, height: 240, cx: 190, cy: 118, ") +
                  GetParam().camera +
                  "}\ncam_from_body: {rotation: [0, -1, 0, -1, 0, 0, 0, 0, -1], translation_m: "
                  "[0.04, 0, -0.03]}\n");
  }

  nlohmann::json Fly(std::vector<std::string> flight, std::vector<std::string> more) {
    flight.insert(flight.end(), {"--config", "c.yaml", "--output", "rec", "--jitter_ms", "0"});
    more.insert(more.end(), {"--dataset", "rec", "--config", "c.yaml", "--output", "out"});
    const ProgramRun made = RunProgram(folder_.path(), "tagtwist_simulate", flight);
    EXPECT_EQ(made.status, 0) << made.err;
    const ProgramRun run = RunProgram(folder_.path(), "tagtwist_estimate", more);
    EXPECT_EQ(run.status, 0) << run.err;
    told_ = run.err;
    return nlohmann::json::parse(ReadText(folder_ / "out/summary.json"));
  }

  const TempFolder folder_;
  std::string told_;
};

// Root mean squares of some hundred frames: errors last for parts of a second, so that 1.2 is some
// standard deviations of chance.
TEST_P(LensesProgram, CornersAreEstimatedAsWellAsCanBe) {
  const auto summary = Fly({"--images=false", "--duration", "12", "--rate", "30"},
                           {"--use_detections", "--tracks=false"});
  EXPECT_EQ(told_, "");
  const auto& ratio = summary["bound"]["rmse_over_bound"];
  for (const char* part : {"position", "rotation", "velocity", "rate"}) {
    EXPECT_LT(ratio[part].get<double>(), 1.2) << part;
    EXPECT_GT(ratio[part].get<double>(), 0.6) << part;
  }
}

TEST_P(LensesProgram, SlowImagesAreEstimatedAsWellAsTheirCornersAllow) {
  const auto summary = Fly({"--duration", "1.5", "--rate", "20", "--supersampling", "3",
                            "--scribble", "0", "--exposure_ms", "0"},
                           {"--tracks=false"});
  EXPECT_TRUE(told_.empty() || told_.find("single tag observation") != std::string::npos) << told_;
  EXPECT_EQ(summary["frames"], summary["frames_estimated"]);
  const auto& accuracy = summary["accuracy"]["optimised"];
  EXPECT_LT(accuracy["position_rmse_m"].get<double>(), 2e-3);
  EXPECT_LT(accuracy["rotation_rmse_rad"].get<double>(), 2e-3);
  EXPECT_LT(summary["reprojection_px"]["median"].get<double>(), 0.2);
}

constexpr auto kNameOf = [](const auto& test) { return std::string(test.param.name); };
INSTANTIATE_TEST_SUITE_P(All, LensesProgram,
                         testing::Values(Lens{
                             "DoubleSphere",
                             "fx: 170, fy: 171, distortion_model: ds, distortion: [-0.2, 0.59]"}),
                         kNameOf);
INSTANTIATE_TEST_SUITE_P(
    SlowAll, LensesProgram,
    testing::Values(
        Lens{"ExtendedUnified", "fx: 210, fy: 212, distortion_model: eucm, distortion: [0.6, 1.1]"},
        Lens{"Omni",
             "fx: 420, fy: 418, distortion_model: omni, distortion: [0.99, -0.2, 0.07, 1e-3, "
             "-5e-4]"},
        Lens{"FieldOfView", "fx: 200, fy: 201, distortion_model: fov, distortion: [0.9]"}),
    kNameOf);

}  // namespace
}  // namespace tagtwist::internal::lenses_program_test
