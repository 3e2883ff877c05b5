#include <ceres/gradient_checker.h>
#include <ceres/manifold_test_utils.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "frontend/types/so3.h"
#include "residuals/motion_residual.h"
#include "residuals/pose_manifold.h"
#include "residuals/prior_residual.h"
#include "residuals/tag_reprojection_residual.h"
#include "residuals/track_residual.h"

namespace tagtwist {
namespace {

class Residuals : public testing::Test {
 protected:
  double Uniform() { return std::uniform_real_distribution<double>(-1, 1)(rng_); }
  Eigen::Vector3d Vec() { return {Uniform(), Uniform(), Uniform()}; }
  Pose RandomPose(double angle) { return MakePose(ExpSo3(angle * Vec().normalized()), 5 * Vec()); }

  /// Analytic against numeric Jacobian, in the tangent; blocks of 7 parameters are poses.
  void ExpectCorrectJacobians(const ceres::CostFunction& residual,
                              const std::vector<const double*>& blocks) {
    const PoseManifold pose;
    std::vector<const ceres::Manifold*> manifolds;
    for (const int size : residual.parameter_block_sizes()) {
      manifolds.push_back(size == 7 ? &pose : nullptr);
    }
    ceres::NumericDiffOptions numeric;
    numeric.ridders_relative_initial_step_size = 1e-3;  // 1e-2 calls correct Jacobians wrong
    ceres::GradientChecker checker(&residual, &manifolds, numeric);
    ceres::GradientChecker::ProbeResults results;
    checker.Probe(blocks.data(), 1e-8, &results);  // its verdict is relative to each entry, so that
    ASSERT_TRUE(results.return_value);             // rounding of a zero entry fails: judge here
    for (size_t i = 0; i < results.local_jacobians.size(); ++i) {
      const ceres::Matrix& analytic = results.local_jacobians[i];
      const double largest = analytic.cwiseAbs().maxCoeff();
      EXPECT_GT(largest, 1e-3) << "a zero Jacobian would prove nothing";
      const ceres::Matrix error = analytic - results.local_numeric_jacobians[i];
      EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-9 * largest) << "block " << i << "\n" << error;
    }
  }

  std::mt19937 rng_{11};
};

const Camera& Lens() {
  static const Camera camera = [] {
    Camera c;
    c.width = 640, c.height = 480, c.fx = 600, c.fy = 580, c.cx = 320, c.cy = 240;
    c.k1 = -0.2, c.k2 = 0.05, c.p1 = 1e-3, c.p2 = -2e-3, c.k3 = 0.01;
    return c;
  }();
  return camera;
}
const Pose& CamFromBody() {
  static const Pose pose = MakePose(ExpSo3({0.3, -0.6, 0.2}), {0.1, -0.05, 0.02});
  return pose;
}
// Every corner's coordinates go together with every other's.
const Eigen::Matrix<double, 8, 8> kFull = [] {
  Eigen::Matrix<double, 8, 8> a;
  for (int i = 0; i < 64; ++i) a.data()[i] = std::sin(1.0 + 3.0 * i);
  return Eigen::Matrix<double, 8, 8>(a * a.transpose() + Eigen::Matrix<double, 8, 8>::Identity());
}();

struct TagScene {
  Pose world_from_body;
  TagObservation tag;
  TagObservation exact;  // the pixels where the corners project
};

class TagResidual : public Residuals {
 protected:
  TagScene RandomScene() {
    TagScene s;
    s.world_from_body = RandomPose(3.1 * std::abs(Uniform()));
    for (size_t i = 0; i < 4; ++i) {
      const Eigen::Vector3d in_cam(0.6 * Uniform(), 0.6 * Uniform(), 2.0 + Uniform());
      s.tag.corners_in_world[i] = s.world_from_body * (Inverse(CamFromBody()) * in_cam);
      EXPECT_TRUE(Lens().Project(in_cam, &s.tag.pixels[i]));
    }
    s.tag.covariance = kFull;
    s.exact = s.tag;
    for (auto& pixel : s.tag.pixels) pixel += Eigen::Vector2d(Uniform(), Uniform());
    return s;
  }
};

TEST_F(TagResidual, JacobianMatchesNumericOne) {
  for (int i = 0; i < 50; ++i) {
    const TagScene s = RandomScene();
    ExpectCorrectJacobians(TagReprojectionResidual(s.tag, Lens(), CamFromBody()),
                           {s.world_from_body.params.data()});
  }
}

TEST_F(TagResidual, JacobianHoldsWithoutRotationAndAtGrazingView) {
  TagScene s = RandomScene();
  s.world_from_body = Pose{};
  for (size_t i = 0; i < 4; ++i) {
    const double side = i % 2 == 0 ? -0.1 : 0.1;
    s.tag.corners_in_world[i] =
        Inverse(CamFromBody()) * Eigen::Vector3d(side, 1e-4 * static_cast<double>(i), 0.5 + side);
  }
  ExpectCorrectJacobians(TagReprojectionResidual(s.tag, Lens(), CamFromBody()),
                         {s.world_from_body.params.data()});
}

TEST_F(TagResidual, SquaredNormIsMahalanobisDistance) {
  const TagScene s = RandomScene();
  const double* blocks[] = {s.world_from_body.params.data()};
  double r[8];
  ASSERT_TRUE(TagReprojectionResidual(s.tag, Lens(), CamFromBody()).Evaluate(blocks, r, nullptr));
  Eigen::Matrix<double, 8, 1> e;
  for (size_t i = 0; i < 4; ++i) {
    e.segment<2>(2 * static_cast<int>(i)) = s.exact.pixels[i] - s.tag.pixels[i];
  }
  const double expected = e.dot(kFull.inverse() * e);
  EXPECT_NEAR((Eigen::Map<Eigen::Matrix<double, 8, 1>>(r).squaredNorm()), expected, 1e-9);
}

TEST_F(TagResidual, RefusesCornerBehindCamera) {
  TagScene s = RandomScene();
  s.tag.corners_in_world[2] =
      s.world_from_body * (Inverse(CamFromBody()) * Eigen::Vector3d(0, 0, -1));
  const double* blocks[] = {s.world_from_body.params.data()};
  double r[8];
  EXPECT_FALSE(TagReprojectionResidual(s.tag, Lens(), CamFromBody()).Evaluate(blocks, r, nullptr));
}

class Track : public Residuals {};

TEST_F(Track, JacobianMatchesNumericOneOnAnyPlane) {
  for (int i = 0; i < 50; ++i) {
    const Pose world_from_body = RandomPose(3.0 * Uniform());
    const Pose world_from_plane =
        world_from_body * Inverse(CamFromBody()) *
        MakePose(ExpSo3({0.5 * Uniform(), 0.5 * Uniform(), Uniform()}), {0.1, 0.1, 2.0});
    const Eigen::Vector2d point(0.3 * Uniform(), 0.3 * Uniform());
    ExpectCorrectJacobians(TrackResidual({300, 200}, 0.4, world_from_plane, Lens(), CamFromBody()),
                           {world_from_body.params.data(), point.data()});
  }
}

TEST_F(Track, IsWhitenedByItsSigma) {
  const Pose world_from_body = RandomPose(1.0);
  const Eigen::Vector3d in_cam(0.1, -0.2, 1.5);
  const Pose world_from_plane =
      MakePose(Eigen::Quaterniond::Identity(), world_from_body * (Inverse(CamFromBody()) * in_cam));
  Eigen::Vector2d pixel;
  ASSERT_TRUE(Lens().Project(in_cam, &pixel));
  const Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  const double* blocks[] = {world_from_body.params.data(), origin.data()};
  Eigen::Vector2d r;
  ASSERT_TRUE(
      TrackResidual(pixel - Eigen::Vector2d(3, 4), 0.5, world_from_plane, Lens(), CamFromBody())
          .Evaluate(blocks, r.data(), nullptr));
  EXPECT_NEAR(r.norm(), 10.0, 1e-9);
}

TEST_F(Track, RefusesPointBehindCamera) {
  const Pose world_from_body;
  const Pose behind = Inverse(CamFromBody()) * MakePose(Eigen::Quaterniond::Identity(), {0, 0, -1});
  const Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  const double* blocks[] = {world_from_body.params.data(), origin.data()};
  double r[2];
  EXPECT_FALSE(
      TrackResidual({0, 0}, 1, behind, Lens(), CamFromBody()).Evaluate(blocks, r, nullptr));
}

using Vector6 = Eigen::Matrix<double, 6, 1>;

using Vector12 = Eigen::Matrix<double, 12, 1>;
constexpr WhiteNoiseOn kBothPriors[] = {WhiteNoiseOn::kAcceleration, WhiteNoiseOn::kJerk};

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
  for (const WhiteNoiseOn on : kBothPriors) {
    const MotionPrior linear{on, 0.7}, angular{on, 3.0};
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
  for (const WhiteNoiseOn on : kBothPriors) {
    const MotionPrior prior{on, 0.7};
    const Eigen::Matrix3d f = Transition(on, 0.3);
    EXPECT_LT((f * Transition(on, 0.2) - Transition(on, 0.5)).norm(), 1e-12);
    const Eigen::Matrix3d q =
        f * ProcessCovariance(prior, 0.2) * f.transpose() + ProcessCovariance(prior, 0.3);
    EXPECT_LT((q - ProcessCovariance(prior, 0.5)).norm(), 1e-12);
  }
}

class Prior : public Residuals {};

TEST_F(Prior, JacobianMatchesNumericOneAwayFromItsReference) {
  for (int i = 0; i < 20; ++i) {
    const Pose reference = RandomPose(2.0 * Uniform());
    const Pose pose =
        MakePose(reference.rotation() * ExpSo3(0.8 * Vec()), reference.translation() + Vec());
    const Vector12 rates = Vector12::Random();
    const PriorResidual residual({{false, Vector12::Zero()}, {true, reference.params}},
                                 Eigen::MatrixXd::Random(15, 18), Eigen::VectorXd::Random(15));
    ExpectCorrectJacobians(residual, {rates.data(), pose.params.data()});
  }
}

TEST_F(Prior, IsItsOffsetAtTheReference) {
  const Pose reference = RandomPose(1.0);
  const Eigen::VectorXd offset = Eigen::VectorXd::LinSpaced(6, 1, 6);
  const PriorResidual residual({{true, reference.params}}, Eigen::MatrixXd::Identity(6, 6), offset);
  const double* blocks[] = {reference.params.data()};
  Eigen::Matrix<double, 6, 1> r;
  ASSERT_TRUE(residual.Evaluate(blocks, r.data(), nullptr));
  EXPECT_LT((r - offset).norm(), 1e-12);
}

TEST_F(Residuals, PoseManifoldInvariants) {
  using namespace ceres;  // NOLINT: the macro of Ceres 2.1 names its matchers unqualified
  const PoseManifold manifold;
  for (int i = 0; i < 20; ++i) {
    const ceres::Vector x = RandomPose(3 * Uniform()).params;
    const ceres::Vector delta = 0.3 * ceres::Vector::Random(6);
    ceres::Vector y(7);  // near x: the macro compares coefficients, and q and -q are one rotation
    ASSERT_TRUE(manifold.Plus(x.data(), delta.data(), y.data()));
    EXPECT_THAT_MANIFOLD_INVARIANTS_HOLD(manifold, x, delta, y, 1e-8);
  }
}

}  // namespace
}  // namespace tagtwist
