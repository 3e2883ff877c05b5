#include "frontend/types/pose.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "frontend/base/statistics/robust.h"
#include "frontend/types/nees.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal::pose_test {
namespace {

Pose SomePose() { return MakePose(ExpSo3({0.3, -1.1, 0.7}), {1, -2, 0.5}); }

PoseStep SomeStep(double scale) {
  PoseStep step;
  step << 0.4, -0.2, 0.9, 2, -1, 0.3;
  return scale * step;
}

TEST(Pose, DifferenceIsTheStepThatRetractTook) {
  for (const double scale : {0.0, 1e-9, 1e-3, 1.0, 2.5}) {
    const PoseStep step = SomeStep(scale),
                   found = Difference(Retract(SomePose(), step), SomePose());
    EXPECT_LT((found - step).norm(), 1e-12) << scale;
  }
}

// M1 of docs/maths.md: the rotation on the right, in the body's frame; the translation in the
// world.
TEST(Pose, AStepTurnsInTheBodyAndShiftsInTheWorld) {
  const PoseStep step = SomeStep(0.5);
  const Pose moved = Retract(SomePose(), step);
  const Eigen::Matrix3d turn = ExpSo3(step.head<3>()).toRotationMatrix();
  EXPECT_LT((moved.rotation().toRotationMatrix() - SomePose().rotation().toRotationMatrix() * turn)
                .norm(),
            1e-14);
  EXPECT_LT((moved.translation() - SomePose().translation() - step.tail<3>()).norm(), 1e-14);
}

TEST(Pose, AngleBetweenIsThatOfTheTurnAlone) {
  EXPECT_EQ(AngleBetween(SomePose(), SomePose()), 0);
  const Pose moved = Retract(SomePose(), SomeStep(1));
  EXPECT_NEAR(AngleBetween(SomePose(), moved), SomeStep(1).head<3>().norm(), 1e-14);
  EXPECT_NEAR(AngleBetween(moved, SomePose()), SomeStep(1).head<3>().norm(), 1e-14);
}

TEST(TwistBetween, IsThatWhichLeadsFromOneToTheOther) {
  const Pose second = Retract(SomePose(), SomeStep(0.1));
  const Twist twist = TwistBetween(SomePose(), second, 0.1);
  EXPECT_LT((twist.omega_body - SomeStep(1).head<3>()).norm(), 1e-12);
  EXPECT_LT((twist.v_world - SomeStep(1).tail<3>()).norm(), 1e-12);
}

TEST(Huber, IsHalfTheSquareThenItsTangent) {
  const double delta = HuberDelta(2, 8);
  EXPECT_NEAR(delta, 2 * std::sqrt(8.0), 1e-15);
  for (const double norm : {0.0, 0.5 * delta, delta}) {
    EXPECT_EQ(Huber(norm * norm, delta).weight, 1);
    EXPECT_NEAR(Huber(norm * norm, delta).cost, 0.5 * norm * norm, 1e-14);
  }
  for (const double norm : {1.5 * delta, 10 * delta}) {
    const RobustLoss loss = Huber(norm * norm, delta);
    EXPECT_NEAR(loss.cost, 0.5 * delta * delta + delta * (norm - delta), 1e-12) << norm;
    // The weighted residual has the slope of the cost: weight * norm = d cost / d norm.
    EXPECT_NEAR(loss.weight * norm, delta, 1e-12) << norm;
  }
  EXPECT_EQ(Huber(1e6, 0).weight, 1) << "no threshold: no robust loss";
}

TEST(Nees, IsTheSquaredDistanceInTheCovarianceOfThePartsAskedFor) {
  BodyState estimate;
  estimate.world_from_body = SomePose();
  StateVector error = StateVector::LinSpaced(-0.3, 0.8);
  StateCovariance root = StateCovariance::Identity();
  for (int i = 0; i < 12; ++i) root(i, (5 * i + 3) % 12) += 0.1 * (i + 1);
  const StateCovariance p = root * root.transpose();
  const BodyState truth = Retract(estimate, error);
  const auto whole = Nees(truth, estimate, p, kWholeState);
  ASSERT_TRUE(whole);
  EXPECT_NEAR(*whole, error.dot(p.inverse() * error), 1e-9 * *whole);
  const auto position = Nees(truth, estimate, p, kPositionEntries);
  ASSERT_TRUE(position);
  const Eigen::Vector3d e = error.segment<3>(3);
  EXPECT_NEAR(*position, e.dot(p.block<3, 3>(3, 3).inverse() * e), 1e-9 * *position);
}

TEST(Nees, IsNotThereWithoutACovariance) {
  StateCovariance p = StateCovariance::Identity();
  p(4, 4) = -1;
  EXPECT_FALSE(Nees({}, {}, p, kWholeState));
  EXPECT_FALSE(Nees({}, {}, p, kPositionEntries));
  EXPECT_TRUE(Nees({}, {}, p, kTwistEntries));
  p(4, 4) = std::nan("");
  EXPECT_FALSE(Nees({}, {}, p, kPoseEntries));
}

}  // namespace
}  // namespace tagtwist::internal::pose_test
