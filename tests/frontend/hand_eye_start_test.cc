#include "frontend/geometry/hand_eye_start.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "frontend/types/so3.h"
#include "tests/support/draws.h"

namespace tagtwist::internal::hand_eye_start_test {
namespace {

struct Paths {
  std::vector<Pose> cams, bodies;
};

const Pose kMount = MakePose(ExpSo3({0.3, -2.1, 1.2}), {0.1, -0.2, 0.05});
const Pose kWorld = MakePose(ExpSo3({-0.4, 0.2, 2.9}), {5, -3, 1});

// Turns about `axes`, with noise of the truth.
Paths Draw(const Eigen::Vector3d& axes, double noise) {
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  Paths out;
  for (int i = 0; i < 300; ++i) {
    const double t = 0.1 * i;
    const Eigen::Vector3d turn(std::sin(0.9 * t), std::sin(0.7 * t + 1), std::sin(0.5 * t + 2));
    const Pose cam = MakePose(ExpSo3(axes.cwiseProduct(turn)), {std::sin(t), std::cos(0.8 * t), 1});
    const Eigen::Vector3d off = noise * DrawVector<3>(normal, rng);
    out.cams.push_back(cam);
    out.bodies.push_back(kWorld * cam * kMount * MakePose(ExpSo3(off), off));
  }
  return out;
}

TEST(HandEyeStart, MountAndWorldComeFromNothing) {
  for (const double noise : {0.0, 0.003}) {
    const Paths paths = Draw({0.5, 0.4, 0.8}, noise);
    const auto found = FindHandEyeStart(paths.cams, paths.bodies);
    ASSERT_TRUE(found);
    EXPECT_LT(Difference(found->cam_from_body, kMount).norm(), 1e-9 + noise);
    EXPECT_LT(Difference(found->truth_from_world, kWorld).norm(), 1e-9 + 2 * noise);
  }
}

TEST(HandEyeStart, NoneWhereTheMotionDoesNotSayIt) {
  EXPECT_FALSE(FindHandEyeStart(Draw({0, 0, 0.8}, 0.001).cams, Draw({0, 0, 0.8}, 0.001).bodies));
  EXPECT_FALSE(FindHandEyeStart(Draw({0, 0, 0}, 0.001).cams, Draw({0, 0, 0}, 0.001).bodies));
  const Paths paths = Draw({0.5, 0.4, 0.8}, 0);
  std::vector<Pose> others(paths.bodies.rbegin(), paths.bodies.rend());
  EXPECT_FALSE(FindHandEyeStart(paths.cams, others)) << "turns of another recording";
  EXPECT_FALSE(FindHandEyeStart({}, {}));
}

}  // namespace
}  // namespace tagtwist::internal::hand_eye_start_test
