#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "frontend/types/so3.h"
#include "residuals/corner_whitener.h"
#include "residuals/lens.h"
#include "residuals/tag_calibration_residual.h"
#include "residuals/truth_residual.h"

namespace tagtwist::internal::calibration_residuals_test {
namespace {

class CalibrationResiduals : public testing::Test {
 protected:
  double Uniform() { return std::uniform_real_distribution<double>(-1, 1)(rng_); }
  Eigen::Vector3d Vec() { return {Uniform(), Uniform(), Uniform()}; }
  Pose RandomPose(double angle) {
    const Eigen::Vector3d translation = Vec();
    return MakePose(ExpSo3(angle * Vec()), translation);
  }
  std::mt19937 rng_{3};
};

Camera Lens() {
  Camera c;
  c.width = 640, c.height = 480, c.fx = 600, c.fy = 580, c.cx = 320, c.cy = 240;
  c.k1 = -0.2, c.k2 = 0.05, c.p1 = 1e-3, c.p2 = -2e-3, c.k3 = 0.01;
  c.k4 = 0.03, c.k5 = -0.01, c.k6 = 0.004;
  return c;
}

using Function = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

// Analytic against central differences of fourth order, relative to its largest entry.
void ExpectDerivative(const Eigen::MatrixXd& analytic, const Function& f) {
  constexpr double kStep = 1e-3;
  ASSERT_GT(analytic.cwiseAbs().maxCoeff(), 1e-3) << "a zero Jacobian would prove nothing";
  for (Eigen::Index i = 0; i < analytic.cols(); ++i) {
    const Eigen::VectorXd unit = kStep * Eigen::VectorXd::Unit(analytic.cols(), i);
    const Eigen::VectorXd numeric =
        (8 * (f(unit) - f(-unit)) - (f(2 * unit) - f(-2 * unit))) / (12 * kStep);
    EXPECT_LT((analytic.col(i) - numeric).norm(), 1e-7 * analytic.cwiseAbs().maxCoeff())
        << "column " << i;
  }
}

constexpr double kLineTimeS = 1e-4;

TEST_F(CalibrationResiduals, TagDerivativesMatchNumericOnes) {
  Eigen::Matrix<double, 8, 8> root;
  for (int i = 0; i < 64; ++i) root.data()[i] = std::sin(1.0 + 3.0 * i);
  const Eigen::Matrix<double, 8, 8> whitener =
      CornerWhitener(root * root.transpose() + Eigen::Matrix<double, 8, 8>::Identity());
  for (int round = 0; round < 20; ++round) {
    const Pose world_from_cam = RandomPose(2);
    Tag tag;
    tag.size_m = 0.2;
    tag.bend_m = 0.02 * Uniform();
    const Eigen::Vector3d place{0.4 * Uniform(), 0.4 * Uniform(), 1.5};
    tag.world_from_tag = world_from_cam * MakePose(ExpSo3(Vec()), place);
    const std::array<Eigen::Vector2d, 4> pixels = {
        Eigen::Vector2d(300, 200), Eigen::Vector2d(320, 200), Eigen::Vector2d(320, 220),
        Eigen::Vector2d(300, 220)};
    const double log_scale = 0.02 * Uniform();
    const Twist motion{Vec(), Vec()};
    // d: [camera 6, tag 6, its bend, log scale, lens, line time in units of its own].
    const auto at = [&](const Eigen::VectorXd& d, TagCalibrationResidual* out) {
      Tag moved = tag;
      moved.world_from_tag = Retract(tag.world_from_tag, d.segment<6>(6));
      moved.bend_m += d(12);
      EXPECT_TRUE(EvaluateTagCalibration(moved, std::exp(log_scale + d(13)),
                                         PerturbLens(Lens(), d.segment(14, 12)),
                                         Retract(world_from_cam, d.head<6>()), pixels, whitener,
                                         {kLineTimeS + kLineTimeS * d(26), motion}, out));
    };
    TagCalibrationResidual linear;
    at(Eigen::VectorXd::Zero(27), &linear);
    Eigen::MatrixXd analytic(8, 27);
    analytic << linear.by_cam, linear.by_tag, linear.by_log_scale, linear.by_lens,
        kLineTimeS * linear.by_line_time;
    for (const auto& columns :
         {std::pair(0, 6), std::pair(6, 6), std::pair(12, 1), std::pair(13, 1), std::pair(14, 2),
          std::pair(16, 2), std::pair(18, 8), std::pair(26, 1)}) {
      const int first = columns.first, n = columns.second;
      ExpectDerivative(analytic.middleCols(first, n), [&](const Eigen::VectorXd& step) {
        Eigen::VectorXd d = Eigen::VectorXd::Zero(27);
        d.segment(first, n) = step;
        TagCalibrationResidual moved;
        at(d, &moved);
        return Eigen::VectorXd(moved.residual);
      });
    }
  }
}

// Every lens model's pixel by its focal lengths, centre and coefficients.
TEST_F(CalibrationResiduals, LensDerivativesMatchNumericOnes) {
  for (const LensModel model :
       {LensModel::kRadialTangential, LensModel::kEquidistant, LensModel::kDoubleSphere,
        LensModel::kExtendedUnified, LensModel::kOmni, LensModel::kFieldOfView}) {
    Camera camera = Lens();
    camera.lens = model;
    camera.xi = 0.4, camera.alpha = 0.55, camera.beta = 1.1, camera.w = 0.9;
    for (int round = 0; round < 20; ++round) {
      const double y = 0.6 * Uniform(), x = 0.6 * Uniform();
      const Eigen::Vector3d point(x, y, 1.2);
      Eigen::Vector2d pixel;
      ASSERT_TRUE(camera.Project(point, &pixel));
      const Eigen::MatrixXd analytic = PixelByLens(camera, point, pixel);
      ASSERT_EQ(analytic.cols(), LensSize(camera));
      ExpectDerivative(analytic, [&](const Eigen::VectorXd& step) {
        Eigen::Vector2d moved;
        EXPECT_TRUE(PerturbLens(camera, step).Project(point, &moved));
        return Eigen::VectorXd(moved);
      });
    }
    Camera other = PerturbLens(camera, 0.01 * Eigen::VectorXd::Ones(LensSize(camera)));
    EXPECT_LT((LensDifference(other, camera).array() - 0.01).abs().maxCoeff(), 1e-12);
  }
}

TEST_F(CalibrationResiduals, TagIsSeenWhereAScaledMapHasIt) {
  Tag tag;
  tag.size_m = 0.2;
  tag.bend_m = 0.01;
  tag.world_from_tag = MakePose(Eigen::Quaterniond::Identity(), {0.3, -0.1, 0});
  const Pose world_from_cam = MakePose(ExpSo3({M_PI, 0, 0}), {0.3, 0, 1.2});
  Tag scaled = tag;
  scaled.size_m *= 1.1;
  scaled.bend_m *= 1.1;
  scaled.world_from_tag = MakePose(Eigen::Quaterniond::Identity(), {0.33, -0.11, 0});
  std::array<Eigen::Vector2d, 4> origin;
  origin.fill(Eigen::Vector2d::Zero());
  const Eigen::Matrix<double, 8, 8> identity = Eigen::Matrix<double, 8, 8>::Identity();
  TagCalibrationResidual a, b;
  ASSERT_TRUE(EvaluateTagCalibration(tag, 1.1, Lens(), world_from_cam, origin, identity, {}, &a));
  ASSERT_TRUE(EvaluateTagCalibration(scaled, 1, Lens(), world_from_cam, origin, identity, {}, &b));
  EXPECT_LT((a.residual - b.residual).norm(), 1e-9);
  EXPECT_GT(a.residual.norm(), 100);
}

TEST_F(CalibrationResiduals, BehindTheCameraIsRefused) {
  Tag tag;
  tag.size_m = 0.2;
  tag.world_from_tag = MakePose(Eigen::Quaterniond::Identity(), {0, 0, -1});
  TagCalibrationResidual out;
  EXPECT_FALSE(EvaluateTagCalibration(tag, 1, Lens(), Pose(), {},
                                      Eigen::Matrix<double, 8, 8>::Identity(), {}, &out));
}

TEST_F(CalibrationResiduals, TruthDerivativesMatchNumericOnes) {
  for (int round = 0; round < 20; ++round) {
    const Pose world = RandomPose(1), cam = RandomPose(2), mount = RandomPose(2);
    const Pose truth = Retract(world * cam * mount, 0.3 * Eigen::VectorXd::Random(6));
    const Twist rate{Vec(), Vec()};
    // d: [camera 6, world 6, mount 6, offset].
    const auto at = [&](const Eigen::VectorXd& d) {
      const Pose later = MakePose(truth.rotation() * ExpSo3(d(18) * rate.omega_body),
                                  truth.translation() + d(18) * rate.v_world);
      return EvaluateTruth(later, rate, Retract(world, d.segment<6>(6)), Retract(cam, d.head<6>()),
                           Retract(mount, d.segment<6>(12)));
    };
    const TruthResidual linear = at(Eigen::VectorXd::Zero(19));
    Eigen::MatrixXd analytic(6, 19);
    analytic << linear.by_cam, linear.by_world, linear.by_mount, linear.by_offset;
    ExpectDerivative(analytic,
                     [&](const Eigen::VectorXd& d) { return Eigen::VectorXd(at(d).residual); });
  }
}

TEST_F(CalibrationResiduals, LensDifferenceUndoesPerturb) {
  const Eigen::VectorXd step = 0.01 * Eigen::VectorXd::LinSpaced(LensSize(Lens()), -3, 5);
  const Camera moved = PerturbLens(Lens(), step);
  EXPECT_LT((LensDifference(moved, Lens()) - step).norm(), 1e-12);
  EXPECT_GT(std::abs(moved.fy / moved.fx - Lens().fy / Lens().fx), 1e-3);
}

}  // namespace
}  // namespace tagtwist::internal::calibration_residuals_test
