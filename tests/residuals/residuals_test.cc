#include <ceres/manifold_test_utils.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "frontend/types/so3.h"
#include "residuals/pose_manifold.h"
#include "residuals/prior_residual.h"
#include "residuals/tag_reprojection_residual.h"
#include "residuals/track_residual.h"
#include "tests/support/residual_check.h"

namespace tagtwist::internal::residuals_test {
namespace {

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

TEST_F(TagResidual, JacobianOfACameraThatStandsMatchesNumericOne) {
  const Pose cam_from_world = CamFromBody();
  for (int i = 0; i < 50; ++i) {
    const Pose cam_from_body =
        MakePose(ExpSo3(3.1 * std::abs(Uniform()) * Vec().normalized()), {0.3, -0.2, 3});
    const Pose world_from_body = Inverse(cam_from_world) * cam_from_body;
    TagObservation tag;
    tag.covariance = kFull;
    for (size_t c = 0; c < 4; ++c) {
      tag.corners_in_world[c] = 0.5 * Vec();  // in the body
      ASSERT_TRUE(Lens().Project(cam_from_body * tag.corners_in_world[c], &tag.pixels[c]));
    }
    const TagReprojectionResidual residual(tag, Lens(), cam_from_world, MountedOn::kWorld);
    ExpectCorrectJacobians(residual, {world_from_body.params.data()});
    Eigen::Matrix<double, 8, 1> error;
    ASSERT_TRUE(residual.Linearize(world_from_body.params.data(), &error, nullptr));
    EXPECT_LT(error.norm(), 1e-8);
  }
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

// Whatever of W is kept: nothing, its diagonal, or all of it.
TEST_F(TagResidual, WhitenerOfAnyCovarianceIsW) {
  using Matrix8 = Eigen::Matrix<double, 8, 8>;
  TagScene s = RandomScene();
  const Matrix8 diagonal = kFull.diagonal().asDiagonal();
  for (const Matrix8& covariance : {Matrix8(Matrix8::Identity()), diagonal, Matrix8(kFull)}) {
    s.tag.covariance = covariance;
    const TagReprojection tag(s.tag, Lens(), CamFromBody());
    const Matrix8 w = tag.whitener();
    EXPECT_LT((w.transpose() * w - covariance.inverse()).norm(),
              1e-9 * covariance.inverse().norm());
    EXPECT_NEAR(tag.LogDetInformation(), -std::log(covariance.determinant()), 1e-9);
    Eigen::Matrix<double, 8, 1> r, e;
    ASSERT_TRUE(tag.Linearize(s.world_from_body.params.data(), &r, nullptr));
    for (size_t i = 0; i < 4; ++i) {
      e.segment<2>(2 * static_cast<int>(i)) = s.exact.pixels[i] - s.tag.pixels[i];
    }
    EXPECT_NEAR(r.squaredNorm(), e.dot(covariance.inverse() * e), 1e-9 * r.squaredNorm());
  }
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
}  // namespace tagtwist::internal::residuals_test
