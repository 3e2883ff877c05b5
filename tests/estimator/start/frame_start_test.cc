#include "estimator/start/frame_start.h"

#include <gtest/gtest.h>

#include "estimator/start/leaps.h"
#include "frontend/types/so3.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::frame_start_test {
namespace {

TEST(FrameStart, WithinReachIsTenMetresAndTwentyRadiansASecondAndTheNoise) {
  const Pose start = MakePose(ExpSo3({0.2, 0.1, 1}), {1, 2, 3});
  const auto reaches = [&start](double metres, double rad) {
    const Pose moved = MakePose(start.rotation() * ExpSo3({0, rad, 0}),
                                start.translation() + Eigen::Vector3d(0, 0, metres));
    return IsWithinReach(start, moved, 0.1);
  };
  EXPECT_TRUE(reaches(1.01, 0));
  EXPECT_FALSE(reaches(1.03, 0));
  EXPECT_TRUE(reaches(0, 2.09));
  EXPECT_FALSE(reaches(0, 2.11));
}

struct Scene {
  EstimatorSetup setup = CourseSetup();
  NoiseModel noise;
  ExactModelFlight flight;

  Scene() {
    ExactModelOptions model;
    model.frames = 2;
    flight = DrawFlight(model);
    noise.corner_sigma_px = model.corner_sigma_px;
  }
  StateAndCovariance PredictedAt(const Pose& pose) const {
    StateAndCovariance out;
    out.state = flight.truth[1];
    out.state.world_from_body = pose;
    out.covariance.setIdentity();
    out.covariance *= 1e-6;
    return out;
  }
};

TEST(FrameStart, TagsAloneGiveThePose) {
  const Scene scene;
  const FrameStarts out =
      StartFrame(scene.setup, scene.noise, scene.flight.measurements[1], nullptr, std::nullopt);
  ASSERT_FALSE(out.starts.empty());
  EXPECT_FALSE(out.excluded);
  const Pose& pose = out.starts[0].state.world_from_body;
  const Pose& truth = scene.flight.truth[1].world_from_body;
  EXPECT_LT((pose.translation() - truth.translation()).norm(), 0.05);
  EXPECT_LT(LogSo3(pose.rotation().conjugate() * truth.rotation()).norm(), 0.05);
  EXPECT_EQ(out.starts[0].tags.size(), scene.flight.measurements[1].tags.size());
}

TEST(FrameStart, WithoutTagsOnlyAFrameBeforeGivesOne) {
  Scene scene;
  FrameMeasurements blind = scene.flight.measurements[1];
  blind.tags.clear();
  EXPECT_TRUE(StartFrame(scene.setup, scene.noise, blind, nullptr, std::nullopt).starts.empty());
  GraphFrame last;
  last.t_ns = scene.flight.measurements[0].t_ns;
  last.state = scene.flight.truth[0];
  const FrameStarts out = StartFrame(scene.setup, scene.noise, blind, &last, std::nullopt);
  ASSERT_EQ(out.starts.size(), 1U);
  EXPECT_EQ(out.starts[0].t_ns, blind.t_ns);
  EXPECT_TRUE(out.starts[0].tags.empty());
}

// The prediction is sure and the tags say that the body is two metres away, 20 ms later.
TEST(FrameStart, TagsThatTheMotionExcludesAreLeftOutAndTold) {
  const Scene scene;
  const Pose& truth = scene.flight.truth[1].world_from_body;
  const Pose elsewhere = MakePose(truth.rotation(), truth.translation() + Eigen::Vector3d(2, 0, 0));
  GraphFrame last;
  last.t_ns = scene.flight.measurements[0].t_ns;
  last.state = scene.flight.truth[0];
  last.state.world_from_body = elsewhere;
  const FrameStarts out = StartFrame(scene.setup, scene.noise, scene.flight.measurements[1], &last,
                                     scene.PredictedAt(elsewhere));
  ASSERT_TRUE(out.excluded);
  EXPECT_LT((out.excluded->translation() - truth.translation()).norm(), 0.05);
  ASSERT_FALSE(out.starts.empty());
  EXPECT_TRUE(out.starts[0].tags.empty());
}

}  // namespace
}  // namespace tagtwist::internal::frame_start_test
