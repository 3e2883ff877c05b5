#include <ceres/gradient_checker.h>
#include <ceres/manifold_test_utils.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "frontend/types/so3.h"
#include "residuals/constant_velocity_residual.h"
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
const Eigen::Matrix2d kFull = (Eigen::Matrix2d() << 4.0, 1.5, 1.5, 1.0).finished();

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
      s.tag.pixel_covariances[i] = kFull;
      EXPECT_TRUE(Lens().Project(in_cam, &s.tag.pixels[i]));
    }
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
  double r[8], expected = 0;
  ASSERT_TRUE(TagReprojectionResidual(s.tag, Lens(), CamFromBody()).Evaluate(blocks, r, nullptr));
  for (size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d e = s.exact.pixels[i] - s.tag.pixels[i];
    expected += e.dot(kFull.inverse() * e);
  }
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

class ConstantVelocity : public Residuals {
 protected:
  Vector6 RandomTwist(double rate) { return (Vector6() << 2 * Vec(), rate * Vec()).finished(); }
};

TEST_F(ConstantVelocity, JacobianMatchesNumericOne) {
  for (const double angle : {0.0, 1e-6, 0.005, 0.02, 0.5, 2.5, 3.0}) {
    for (const double dt_s : {0.003, 0.02, 1.0}) {
      const Pose pose1 = RandomPose(2.0 * Uniform());
      const Pose pose2 = MakePose(pose1.rotation() * ExpSo3(angle * Vec().normalized()),
                                  pose1.translation() + 0.1 * Vec());
      const Vector6 twist1 = RandomTwist(1.0), twist2 = RandomTwist(1.0);
      ExpectCorrectJacobians(
          ConstantVelocityResidual(dt_s, 0.7, 3.0),
          {pose1.params.data(), twist1.data(), pose2.params.data(), twist2.data()});
    }
  }
}

TEST_F(ConstantVelocity, IsZeroOnConstantVelocity) {
  for (const double dt_s : {0.003, 0.05, 2.0}) {
    const Vector6 twist = RandomTwist(0.8);
    const Pose pose1 = RandomPose(1.0);
    const Pose pose2 = MakePose(pose1.rotation() * ExpSo3(dt_s * twist.tail<3>()),
                                pose1.translation() + dt_s * twist.head<3>());
    const double* blocks[] = {pose1.params.data(), twist.data(), pose2.params.data(), twist.data()};
    Eigen::Matrix<double, 12, 1> r;
    ASSERT_TRUE(ConstantVelocityResidual(dt_s, 1, 1).Evaluate(blocks, r.data(), nullptr));
    EXPECT_LT(r.norm(), 1e-9) << dt_s;
  }
}

TEST_F(ConstantVelocity, SquaredNormIsMahalanobisDistanceUnderTheProcessCovariance) {
  constexpr double kDt = 0.04, kAccel = 0.7, kAngular = 3.0;
  Eigen::Matrix2d q;  // one axis of [dt^3/3, dt^2/2; dt^2/2, dt]
  q << kDt * kDt * kDt / 3, kDt * kDt / 2, kDt * kDt / 2, kDt;
  const Pose pose1;
  const Vector6 twist1 = Vector6::Zero();
  const Eigen::Vector3d e_p = 0.01 * Vec(), e_v = 0.1 * Vec(), e_theta = 0.01 * Vec();
  const Pose pose2 = MakePose(ExpSo3(e_theta), e_p);
  Vector6 twist2;
  const Eigen::Vector3d e_omega = 0.2 * Vec();
  twist2 << e_v, RightJacobianSo3(e_theta) * e_omega;
  const double* blocks[] = {pose1.params.data(), twist1.data(), pose2.params.data(), twist2.data()};
  Eigen::Matrix<double, 12, 1> r;
  ASSERT_TRUE(ConstantVelocityResidual(kDt, kAccel, kAngular).Evaluate(blocks, r.data(), nullptr));
  double expected = 0;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d linear(e_p[i], e_v[i]), angular(e_theta[i], e_omega[i]);
    expected += linear.dot(q.inverse() * linear) / kAccel;
    expected += angular.dot(q.inverse() * angular) / kAngular;
  }
  EXPECT_NEAR(r.squaredNorm(), expected, 1e-9 * expected);
}

class Prior : public Residuals {};

TEST_F(Prior, JacobianMatchesNumericOneAwayFromItsReference) {
  for (int i = 0; i < 20; ++i) {
    const Pose reference = RandomPose(2.0 * Uniform());
    const Pose pose =
        MakePose(reference.rotation() * ExpSo3(0.8 * Vec()), reference.translation() + Vec());
    const Vector6 twist = Vector6::Random();
    const PriorResidual residual({{true, reference.params}, {false, Vector6::Zero()}},
                                 Eigen::MatrixXd::Random(12, 12), Eigen::VectorXd::Random(12));
    ExpectCorrectJacobians(residual, {pose.params.data(), twist.data()});
  }
}

TEST_F(Prior, IsItsOffsetAtTheReference) {
  const Pose reference = RandomPose(1.0);
  const Eigen::VectorXd offset = Eigen::VectorXd::LinSpaced(6, 1, 6);
  const PriorResidual residual({{true, reference.params}}, Eigen::MatrixXd::Identity(6, 6), offset);
  const double* blocks[] = {reference.params.data()};
  Vector6 r;
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
