#include "estimator/start/mirror.h"

#include <gtest/gtest.h>

#include "frontend/types/rig.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal::mirror_test {
namespace {

constexpr double kTiltRad = 0.4;

EstimatorSetup SetupOf(std::vector<Tag> tags) {
  return MakeEstimatorSetup(MakeSetUp(Camera(), Pose(), TagMap("tag36h11", std::move(tags))), {});
}

// A camera that looks at the origin from a distance, the plane z = 0 tilted by kTiltRad.
GraphFrame FrameAt(const EstimatorSetup& setup, double distance_m) {
  const Pose cam_from_world = MakePose(ExpSo3({M_PI - kTiltRad, 0, 0}), {0, 0, distance_m});
  GraphFrame frame;
  frame.state.world_from_body = Inverse(cam_from_world);
  for (const Tag& tag : setup.map.tags()) {
    TagDetection seen;
    seen.id = tag.id;
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_TRUE(setup.camera.Project(cam_from_world * setup.map.CornersInWorld(tag.id)[c],
                                       &seen.corners[c]));
    }
    frame.tags.push_back(seen);
  }
  return frame;
}

Tag TagAt(int id, const Eigen::Vector3d& place, const Eigen::Vector3d& turn = {0, 0, 0}) {
  return {id, MakePose(ExpSo3(turn), place), 0.16};
}

TEST(Mirror, OfAFarTagCostsLittleAndTurnsByTwiceTheTilt) {
  const EstimatorSetup setup = SetupOf({TagAt(3, {0, 0, 0})});
  NoiseModel noise;
  noise.corner_sigma_px = 0.3;
  double last = 1e9;
  for (const double distance_m : {0.6, 1.2, 2.4, 4.8}) {
    const auto mirror = MirrorOf(setup, noise, FrameAt(setup, distance_m));
    ASSERT_TRUE(mirror) << distance_m;
    EXPECT_NEAR(mirror->angle_rad, 2 * kTiltRad, 0.05) << distance_m;
    EXPECT_GT(mirror->cost, 0) << distance_m;
    EXPECT_LT(mirror->cost, 0.5 * last) << distance_m;
    last = mirror->cost;
  }
  EXPECT_LT(last, 9);
}

TEST(Mirror, ItsCostIsThatOfTheNoise) {
  const EstimatorSetup setup = SetupOf({TagAt(3, {0, 0, 0})});
  NoiseModel fine, coarse;
  fine.corner_sigma_px = 0.3;
  coarse.corner_sigma_px = 0.6;
  const GraphFrame frame = FrameAt(setup, 1);
  const auto a = MirrorOf(setup, fine, frame), b = MirrorOf(setup, coarse, frame);
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(a->cost / b->cost, 4, 1e-6);
}

TEST(Mirror, NoTagsAndTwoPlanesHaveNone) {
  const EstimatorSetup setup = SetupOf({TagAt(3, {0, 0, 0}), TagAt(4, {0.3, 0, 0.1}, {0, 0.7, 0})});
  const NoiseModel noise;
  GraphFrame frame = FrameAt(setup, 1.5);
  EXPECT_FALSE(MirrorOf(setup, noise, frame));
  frame.tags.pop_back();
  EXPECT_TRUE(MirrorOf(setup, noise, frame));
  frame.tags.clear();
  EXPECT_FALSE(MirrorOf(setup, noise, frame));
}

}  // namespace
}  // namespace tagtwist::internal::mirror_test
