// One tag, seen nearly face-on: two poses explain each view almost equally well, and the tilt is
// felt only weakly.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "estimator/batch/batch.h"
#include "frontend/types/so3.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"
#include "tests/support/flights/window_run.h"

namespace tagtwist::internal::single_tag_test {
namespace {

constexpr int kTag = 54;

// A body at rest over the tag that begins to sway after a second, by a few centimetres and
// degrees.
std::vector<BodyState> Sway(int frames, double height_m) {
  std::vector<BodyState> truth;
  const Eigen::Vector3d centre =
      MakeTagMap({}).Find(kTag)->world_from_tag.translation() + Eigen::Vector3d(0, 0, height_m);
  for (int i = 0; i < frames; ++i) {
    const double t = std::max(0.0, 0.02 * i - 1);
    const double rise = 1 - std::exp(-t * t);
    const Eigen::Vector3d tilt =
        rise * Eigen::Vector3d(0.04 * std::sin(1.7 * t), 0.03 * std::sin(1.1 * t), 0);
    BodyState state;
    state.world_from_body =
        Hover(centre + rise * Eigen::Vector3d(0.03 * std::sin(1.1 * t), 0.03 * std::sin(t), 0),
              0.05 * rise * std::sin(0.6 * t), tilt);
    truth.push_back(state);
  }
  return truth;
}

struct Flight {
  std::vector<BodyState> truth;
  std::vector<FrameMeasurements> measurements;
};
Flight FlyOverOneTag(double height_m, double noise_px, unsigned seed) {
  const EstimatorSetup setup = CourseSetup();
  const TagMap one(setup.map.family(), {*setup.map.Find(kTag)});
  Flight flight{Sway(500, height_m), {}};
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    FrameMeasurements m;
    m.t_ns = static_cast<int64_t>(i) * 20000000;
    m.tags =
        SeeTags(one, setup.camera, setup.cam_from_body * Inverse(flight.truth[i].world_from_body),
                noise_px, 1000 * seed + static_cast<unsigned>(i));
    flight.measurements.push_back(std::move(m));
  }
  return flight;
}

// Every attitude within 10 degrees and five of its own standard deviations.
void ExpectNoFlip(const std::vector<FrameEstimate>& frames, const std::vector<BodyState>& truth) {
  ASSERT_EQ(frames.size(), truth.size());
  double worst_rad = 0, worst_sigmas = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const StateVector error = Difference(frames[i].state, truth[i]);
    worst_rad = std::max(worst_rad, error.head<3>().norm());
    const Eigen::Vector3d sigma = frames[i].covariance.diagonal().head<3>().cwiseSqrt();
    worst_sigmas =
        std::max(worst_sigmas, error.head<3>().cwiseQuotient(sigma).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst_rad, 0.1745);
  EXPECT_LT(worst_sigmas, 5);
}

TEST(SingleTag, WindowKeepsTheRightMinimum) {
  for (const double height_m : {0.8, 1.2}) {
    const Flight flight = FlyOverOneTag(height_m, 0.15, 3);
    ExpectNoFlip(RunWindow(CourseSetup(), flight.measurements).current, flight.truth);
  }
}

TEST(SingleTag, SlowBatchKeepsTheRightMinimum) {
  const Flight flight = FlyOverOneTag(1.2, 0.15, 4);
  const auto result = RunBatch(CourseSetUp(), {}, flight.measurements);
  ASSERT_TRUE(result) << result.error().message;
  ExpectNoFlip(result->frames, flight.truth);
}

}  // namespace
}  // namespace tagtwist::internal::single_tag_test
