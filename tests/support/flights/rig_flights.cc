#include "tests/support/flights/rig_flights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "estimator/batch/batch.h"
#include "frontend/types/nees.h"
#include "frontend/types/so3.h"
#include "tests/support/flights/tag_scene.h"
#include "tests/support/flights/window_run.h"

namespace tagtwist::internal {
namespace {

double WholeNees(const FrameEstimate& estimate, const BodyState& truth) {
  const auto nees = Nees(truth, estimate.state, estimate.covariance, kWholeState);
  EXPECT_TRUE(nees);
  return nees.value_or(0);
}

}  // namespace

SetUp RigOfThree() {
  SetUp out = CourseSetUp();
  out.rig.cameras.resize(3, out.rig.front());
  for (size_t i = 1; i < 3; ++i) {
    RigCamera& mounted = out.rig.cameras[i];
    const double side = i == 1 ? 1 : -1;
    mounted.name = "cam" + std::to_string(i);
    mounted.camera.fx = mounted.camera.fy = 280 + 60 * side;
    mounted.cam_from_body = MakePose(ExpSo3({0.3 * side, 0.2, 0.1 * side}), {0.1 * side, 0.05, 0}) *
                            out.rig.front().cam_from_body;
  }
  return out;
}

std::vector<TagDetection> SeenByCamera(const SetUp& set_up, int camera, const Pose& world_from_body,
                                       double sigma_px, unsigned seed) {
  const RigCamera& mounted = set_up.rig.cameras[static_cast<size_t>(camera)];
  auto out = SeeTags(set_up.map, mounted.camera, mounted.cam_from_body * Inverse(world_from_body),
                     sigma_px, seed);
  if (out.size() > 3) out.resize(3);
  for (TagDetection& tag : out) tag.camera = camera;
  return out;
}

void ExpectHonestEstimates(const SetUp& set_up,
                           const std::function<ExactModelFlight(const ExactModelOptions&)>& draw) {
  double of_batch = 0, current = 0, lagged = 0;  // sums of NEES, 12 each
  double squares = 0, sigma_squares = 0;         // of batch's position [m^2]
  int n = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const ExactModelOptions model = ModelUnder(WhiteNoiseOn::kJerk, seed);
    const ExactModelFlight flight = draw(model);
    const auto batch = RunBatch(set_up, GivenNoise(model), flight.measurements);
    ASSERT_TRUE(batch) << batch.error().message;
    const WindowRun run =
        RunWindow(MakeEstimatorSetup(set_up, GivenNoise(model)), flight.measurements);
    ASSERT_EQ(run.lagged.size(), flight.truth.size());
    for (size_t i = 5; i < flight.truth.size(); i += 10, ++n) {
      const BodyState& truth = flight.truth[i];
      of_batch += WholeNees(batch->frames[i], truth);
      current += WholeNees(run.current[i], truth);
      lagged += WholeNees(run.lagged[i], truth);
      squares += Difference(batch->frames[i].state, truth).segment<3>(3).squaredNorm();
      sigma_squares += batch->frames[i].covariance.diagonal().segment<3>(3).sum();
    }
  }
  const double band = 4 * std::sqrt(24.0 / n);
  EXPECT_NEAR(of_batch / n, 12, band);
  EXPECT_NEAR(current / n, 12, band);
  EXPECT_NEAR(lagged / n, 12, band);
  EXPECT_LT(squares, 1.44 * sigma_squares);
}

}  // namespace tagtwist::internal
