#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "estimator/start/mirror.h"
#include "frontend/types/rig.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::mirror_doubt_test {
namespace {

constexpr int kTag = 54;

// A body that hangs for some frames beside the place over one tag.
std::vector<GraphFrame> FramesBeside(const EstimatorSetup& setup, double height_m,
                                     double beside_m) {
  const TagMap one(setup.map.family(), {*setup.map.Find(kTag)});
  const Eigen::Vector3d place =
      setup.map.Find(kTag)->world_from_tag.translation() + Eigen::Vector3d(beside_m, 0, height_m);
  std::vector<GraphFrame> out(15);
  for (size_t k = 0; k < out.size(); ++k) {
    out[k].t_ns = static_cast<int64_t>(k) * 33'333'333;
    out[k].state.world_from_body = Hover(place, 0.3, {0, 0, 0});
    out[k].tags = SeeTags(one, setup.camera,
                          setup.cam_from_body * Inverse(out[k].state.world_from_body), 0, 1);
    EXPECT_EQ(out[k].tags.size(), 1U);
  }
  return out;
}

NoiseModel Noise(double corner_sigma_px) {
  NoiseModel out;
  out.corner_sigma_px = corner_sigma_px;
  return out;
}

TEST(MirrorDoubt, IsAHalfWhereNothingTellsAndNoneWhereTheCornersDo) {
  const EstimatorSetup setup = CourseSetup();
  EXPECT_NEAR(MirrorDoubt(setup, Noise(0.2), FramesBeside(setup, 2.5, 0.05)), 0.5, 0.05);
  EXPECT_LT(MirrorDoubt(setup, Noise(0.2), FramesBeside(setup, 0.6, 0.2)), 1e-4);
  EXPECT_EQ(MirrorDoubt(setup, Noise(0.2), {}), 0);
}

TEST(MirrorDoubt, TheMixtureCoversTheMirroredState) {
  const EstimatorSetup setup = CourseSetup();
  const std::vector<GraphFrame> frames = FramesBeside(setup, 2.5, 0.5);
  StateVector sigmas;
  sigmas << Eigen::Vector3d::Constant(0.02), Eigen::Vector3d(0.05, 0.05, 0.005),
      Eigen::Vector3d::Constant(0.1), Eigen::Vector3d::Constant(0.2);
  const StateCovariance alone = sigmas.cwiseAbs2().asDiagonal();
  StateCovariance none = alone, mixed = alone;
  TakeMirrored(setup, frames, 7, 0, &none);
  EXPECT_EQ(none, alone);
  TakeMirrored(setup, frames, 7, 0.4, &mixed);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<StateCovariance>(mixed).eigenvalues()[0], 0);

  std::vector<GraphFrame> mirrored = frames;
  MirrorFrames(setup, {0, static_cast<int>(frames.size()) - 1}, &mirrored);
  const StateVector d = Difference(mirrored[7].state, frames[7].state);
  EXPECT_GT(d.head<3>().norm(), 0.2);
  EXPECT_LT(d.dot(mixed.llt().solve(d)), 1 / 0.4 + 1e-9);
  EXPECT_GT(d.dot(alone.llt().solve(d)), 20);
  // At rest both are, so that nothing is added to the twist.
  EXPECT_NEAR((mixed.block<3, 3>(9, 9).trace()), 0.12, 1e-6);
}

}  // namespace
}  // namespace tagtwist::internal::mirror_doubt_test
