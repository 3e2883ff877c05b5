#include "residuals/motion_residual.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tests/support/residual_check.h"

namespace tagtwist::internal::motion_residual_test {
namespace {

using Vector12 = Eigen::Matrix<double, 12, 1>;
constexpr WhiteNoiseOn kBothPriors[] = {WhiteNoiseOn::kAcceleration, WhiteNoiseOn::kJerk};
const MotionPrior kAllPriors[] = {{WhiteNoiseOn::kAcceleration, 0.7},
                                  {WhiteNoiseOn::kJerk, 0.7},
                                  {WhiteNoiseOn::kJerk, 0.7, false, 0.05}};

class Motion : public Residuals {
 protected:
  Vector12 RandomRates() {
    return (Vector12() << 2 * Vec(), Vec(), 3 * Vec(), 5 * Vec()).finished();
  }
};

TEST_F(Motion, JacobianMatchesNumericOne) {
  for (const WhiteNoiseOn on : kBothPriors) {
    for (const double angle : {0.0, 1e-6, 0.005, 0.02, 0.5, 2.5, 3.0}) {
      for (const double dt_s : {0.003, 0.02, 1.0}) {
        const Pose pose1 = RandomPose(2.0 * Uniform());
        const Pose pose2 = MakePose(pose1.rotation() * ExpSo3(angle * Vec().normalized()),
                                    pose1.translation() + 0.1 * Vec());
        const Vector12 rates1 = RandomRates(), rates2 = RandomRates();
        ExpectCorrectJacobians(
            MotionResidual(dt_s, {on, 0.7}, {on, 3.0}),
            {pose1.params.data(), rates1.data(), pose2.params.data(), rates2.data()});
      }
    }
  }
}

TEST_F(Motion, IsZeroOnConstantVelocity) {
  for (const WhiteNoiseOn on : kBothPriors) {
    for (const double dt_s : {0.003, 0.05, 2.0}) {
      Vector12 rates = RandomRates();
      rates.tail<6>().setZero();
      const Pose pose1 = RandomPose(1.0);
      const Pose pose2 = MakePose(pose1.rotation() * ExpSo3(dt_s * rates.segment<3>(3)),
                                  pose1.translation() + dt_s * rates.head<3>());
      const double* blocks[] = {pose1.params.data(), rates.data(), pose2.params.data(),
                                rates.data()};
      Eigen::Matrix<double, 18, 1> r;
      ASSERT_TRUE(MotionResidual(dt_s, {on, 1}, {on, 1}).Evaluate(blocks, r.data(), nullptr));
      EXPECT_LT(r.norm(), 1e-6) << dt_s;
    }
  }
}

TEST_F(Motion, IsZeroOnConstantAcceleration) {
  constexpr double kDt = 0.2;
  const Eigen::Vector3d v = Vec(), a = Vec(), axis = Vec().normalized();
  const double rate = 0.7, alpha = -1.3;  // about a fixed axis
  const Pose pose1 = RandomPose(1.0);
  const Pose pose2 =
      MakePose(pose1.rotation() * ExpSo3((kDt * rate + kDt * kDt / 2 * alpha) * axis),
               pose1.translation() + kDt * v + kDt * kDt / 2 * a);
  Vector12 rates1, rates2;
  rates1 << v, rate * axis, a, alpha * axis;
  rates2 << v + kDt * a, (rate + kDt * alpha) * axis, a, alpha * axis;
  const double* blocks[] = {pose1.params.data(), rates1.data(), pose2.params.data(), rates2.data()};
  Eigen::Matrix<double, 18, 1> r;
  const MotionPrior jerk{WhiteNoiseOn::kJerk, 1}, accel{WhiteNoiseOn::kAcceleration, 1};
  ASSERT_TRUE(MotionResidual(kDt, jerk, jerk).Evaluate(blocks, r.data(), nullptr));
  EXPECT_LT(r.norm(), 1e-9);
  ASSERT_TRUE(MotionResidual(kDt, accel, accel).Evaluate(blocks, r.data(), nullptr));
  EXPECT_GT(r.norm(), 0.1);
}

TEST_F(Motion, SquaredNormIsMahalanobisDistanceUnderTheProcessCovariance) {
  constexpr double kDt = 0.04;
  for (const MotionPrior& prior : kAllPriors) {
    const MotionPrior linear = WithDensity(prior, 0.7), angular = WithDensity(prior, 3.0);
    Eigen::Matrix3d e_linear, e_angular;  // columns: the quantity and its derivatives
    e_linear << 0.01 * Vec(), 0.1 * Vec(), Vec();
    e_angular << 0.01 * Vec(), 0.2 * Vec(), Vec();
    const Pose pose1, pose2 = MakePose(ExpSo3(e_angular.col(0)), e_linear.col(0));
    const Eigen::Matrix3d jr = RightJacobianSo3(e_angular.col(0));
    const Vector12 rates1 = Vector12::Zero();
    Vector12 rates2;
    rates2 << e_linear.col(1), jr * e_angular.col(1), e_linear.col(2), jr * e_angular.col(2);
    const double* blocks[] = {pose1.params.data(), rates1.data(), pose2.params.data(),
                              rates2.data()};
    Eigen::Matrix<double, 18, 1> r;
    const MotionResidual residual(kDt, linear, angular);
    ASSERT_TRUE(residual.Evaluate(blocks, r.data(), nullptr));
    const Eigen::Matrix3d q_linear = ProcessCovariance(linear, kDt);
    const Eigen::Matrix3d q_angular = ProcessCovariance(angular, kDt);
    double expected = 0;
    for (int i = 0; i < 3; ++i) {
      expected += e_linear.row(i) * q_linear.inverse() * e_linear.row(i).transpose();
      expected += e_angular.row(i) * q_angular.inverse() * e_angular.row(i).transpose();
    }
    EXPECT_NEAR(r.squaredNorm(), expected, 1e-7 * expected);
    EXPECT_NEAR(residual.LogDetInformation(),
                -3 * std::log(q_linear.determinant() * q_angular.determinant()), 1e-7);
  }
}

// Two steps in a row are one: the mean carries on, the noise of the first is carried by the second.
TEST_F(Motion, ProcessCovarianceAddsUpOverTime) {
  for (const MotionPrior& prior : kAllPriors) {
    const Eigen::Matrix3d f = Transition(prior.on, 0.3);
    EXPECT_LT((f * Transition(prior.on, 0.2) - Transition(prior.on, 0.5)).norm(), 1e-12);
    const Eigen::Matrix3d q =
        f * ProcessCovariance(prior, 0.2) * f.transpose() + ProcessCovariance(prior, 0.3);
    EXPECT_LT((q - ProcessCovariance(prior, 0.5)).norm(), 1e-12);
  }
}

// The covariance of a motion with a shake is that of one without and that of white noise on
// acceleration; whitened, the shake's is diagonal.
TEST_F(Motion, TheShakeIsAShareOfEachWhitenedEntry) {
  constexpr double kDt = 0.05;
  for (const double shake_s : {0.0, 0.001, 0.03, 2.0}) {
    const MotionPrior prior{WhiteNoiseOn::kJerk, 0.7, false, shake_s};
    const MotionPrior acceleration{WhiteNoiseOn::kAcceleration, 0.7 * shake_s * shake_s};
    Eigen::Matrix3d shake = ProcessCovariance(acceleration, kDt);
    shake(2, 2) = 0;
    const Eigen::Matrix3d w = RootInformation(prior, kDt);
    EXPECT_LT(
        (ProcessCovariance(prior, kDt) - ProcessCovariance({WhiteNoiseOn::kJerk, 0.7}, kDt) - shake)
            .norm(),
        1e-12);
    const Eigen::Matrix3d share = ShareOfShake(prior, kDt).matrix().asDiagonal();
    EXPECT_LT((w * shake * w.transpose() - share).norm(), 1e-10) << shake_s;
  }
}

}  // namespace
}  // namespace tagtwist::internal::motion_residual_test
