#include "residuals/imu_residual.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/residual_check.h"

namespace tagtwist::internal::imu_residual_test {
namespace {

using Vector12 = Eigen::Matrix<double, 12, 1>;
const Eigen::Vector3d kGravity(0.3, -0.2, -9.8);
constexpr double kLongestStepS = 0.1;

// A body that turns and shakes about all axes, and what an IMU says that has its axes.
Pose PoseAt(double t) {
  const Eigen::Vector3d turn(0.5 * std::sin(2 * t), 0.4 * std::cos(1.5 * t), 0.8 * t);
  return MakePose(ExpSo3(turn),
                  {std::sin(3 * t), 0.5 * std::cos(2 * t), 1 + 0.3 * std::sin(5 * t)});
}
Eigen::Vector3d VelocityAt(double t) {
  return {3 * std::cos(3 * t), -std::sin(2 * t), 1.5 * std::cos(5 * t)};
}
Eigen::Vector3d AccelerationAt(double t) {
  return {-9 * std::sin(3 * t), -2 * std::cos(2 * t), -7.5 * std::sin(5 * t)};
}
Eigen::Vector3d RateAt(double t) {
  constexpr double kH = 1e-5;
  return LogSo3(PoseAt(t - kH).rotation().conjugate() * PoseAt(t + kH).rotation()) / (2 * kH);
}

// Of a place of the body.
Eigen::Vector3d AccelerationAt(double t, const Eigen::Vector3d& in_body) {
  constexpr double kH = 1e-4;
  const auto swing = [&](double at) { return PoseAt(at).rotation() * in_body; };
  return AccelerationAt(t) + (swing(t + kH) - 2 * swing(t) + swing(t - kH)) / (kH * kH);
}

std::vector<ImuSample> Record(double rate_hz, double duration_s, const ImuBias& bias,
                              const Eigen::Vector3d& in_body = Eigen::Vector3d::Zero()) {
  std::vector<ImuSample> out;
  for (int i = 0; i <= std::lround(rate_hz * duration_s); ++i) {
    const double t = i / rate_hz;
    out.push_back({std::llround(1e9 * t),
                   PoseAt(t).rotation().conjugate() * (AccelerationAt(t, in_body) - kGravity) +
                       bias.accel_mps2,
                   RateAt(t) + bias.gyro_radps});
  }
  return out;
}

Vector12 RatesAt(double t, const ImuBias& bias) {
  Vector12 out;
  out << VelocityAt(t), RateAt(t), bias.accel_mps2, bias.gyro_radps;
  return out;
}

class Imu : public Residuals {
 protected:
  ImuBias RandomBias() { return {0.02 * Vec(), 0.3 * Vec()}; }
};

TEST_F(Imu, JacobianMatchesNumericOne) {
  for (const double to_s : {0.02, 0.13, 1.0}) {
    const auto motion =
        Preintegrate(Record(200, 2, {}), 0, std::llround(1e9 * to_s), {}, {}, kLongestStepS);
    ASSERT_TRUE(motion);
    const Pose first = RandomPose(2.0), second = RandomPose(1.0);
    const Vector12 rates1 = RatesAt(0, RandomBias()), rates2 = RatesAt(0.1, RandomBias());
    ExpectCorrectJacobians(
        ImuResidual(*motion, Vec(), kGravity, 1e-3, 1e-2),
        {first.params.data(), rates1.data(), second.params.data(), rates2.data()});
  }
  const Vector12 rates = RatesAt(0.4, RandomBias());
  ExpectCorrectJacobians(GyroRateResidual(Vec(), 0.01), {rates.data()});
  const Vector12 later = RatesAt(0.5, RandomBias());
  ExpectCorrectJacobians(BiasWalkResidual(1e-3, 1e-2), {rates.data(), later.data()});
}

// The residual unwhitened: [theta; v; p] by the covariance's root.
Eigen::Matrix<double, 9, 1> Misfit(double from_s, double to_s, double rate_hz, const ImuBias& bias,
                                   const ImuBias& about,
                                   const Eigen::Vector3d& in_body = Eigen::Vector3d::Zero()) {
  const auto motion = Preintegrate(Record(rate_hz, 3, bias, in_body), std::llround(1e9 * from_s),
                                   std::llround(1e9 * to_s), about, {}, kLongestStepS);
  EXPECT_TRUE(motion);
  const Pose first = PoseAt(from_s), second = PoseAt(to_s);
  const Vector12 rates1 = RatesAt(from_s, bias), rates2 = RatesAt(to_s, bias);
  const double* blocks[] = {first.params.data(), rates1.data(), second.params.data(),
                            rates2.data()};
  Eigen::Matrix<double, 15, 1> r;
  EXPECT_TRUE(ImuResidual(*motion, in_body, kGravity, 1, 1).Evaluate(blocks, r.data(), nullptr));
  return motion->covariance.llt().matrixL() * r.head<9>();
}

// What the body does is what its IMU says: to the steps' order, whatever the ends lie between.
TEST_F(Imu, FitsTheMotionThatItMeasured) {
  const ImuBias bias = RandomBias();
  for (const double to_s : {0.61, 0.7137, 1.5}) {
    const auto coarse = Misfit(0.5033, to_s, 200, bias, bias);
    const auto fine = Misfit(0.5033, to_s, 2000, bias, bias);
    EXPECT_LT(coarse.head<3>().norm(), 2e-4) << to_s;
    EXPECT_LT(coarse.segment<3>(3).norm(), 2e-3) << to_s;
    EXPECT_LT(coarse.tail<3>().norm(), 2e-3) << to_s;
    EXPECT_LT(fine.norm(), 0.05 * coarse.norm()) << to_s;
    const auto away = Misfit(0.5033, to_s, 2000, bias, bias, {0.3, -0.2, 0.5});
    EXPECT_LT(away.norm(), 2e-4) << to_s;
  }
}

TEST_F(Imu, DerivativeByItsPlaceIsTheNumericOne) {
  constexpr double kH = 1e-6;
  const auto motion = Preintegrate(Record(200, 2, {}), 0, 300'000'000, {}, {}, kLongestStepS);
  ASSERT_TRUE(motion);
  const Pose first = RandomPose(2.0), second = RandomPose(1.0);
  const Vector12 rates1 = RatesAt(0, RandomBias()), rates2 = RatesAt(0.1, RandomBias());
  const double* blocks[] = {first.params.data(), rates1.data(), second.params.data(),
                            rates2.data()};
  const Eigen::Vector3d place = Vec();
  const auto by = ImuResidual(*motion, place, kGravity, 1, 1).ByPlace(blocks);
  for (int a = 0; a < 3; ++a) {
    const Eigen::Vector3d step = kH * Eigen::Vector3d::Unit(a);
    Eigen::Matrix<double, 15, 1> up, down;
    ImuResidual(*motion, place + step, kGravity, 1, 1).Evaluate(blocks, up.data(), nullptr);
    ImuResidual(*motion, place - step, kGravity, 1, 1).Evaluate(blocks, down.data(), nullptr);
    EXPECT_LT(((up - down) / (2 * kH) - by.col(a)).norm(), 1e-5 * (1 + by.col(a).norm()));
  }
}

// Biases that it was not made with count to first order.
TEST_F(Imu, FollowsTheBias) {
  const ImuBias bias{0.01 * Vec(), 0.1 * Vec()};
  const double as_made = Misfit(0.5, 0.8, 2000, bias, bias).norm();
  const double moved = Misfit(0.5, 0.8, 2000, bias, {}).norm();
  const double twice =
      Misfit(0.5, 0.8, 2000, {2 * bias.gyro_radps, 2 * bias.accel_mps2}, {}).norm();
  EXPECT_LT(moved, 3e-4);                                      // of some 0.03 that the biases make
  EXPECT_NEAR((twice - as_made) / (moved - as_made), 4, 1.5);  // what is left is of second order
}

// Its covariance is that of integrals over noise of that density.
TEST_F(Imu, CovarianceIsThatOfWhiteNoise) {
  constexpr double kRateHz = 200, kDensity = 0.02;
  const ImuNoise noise{0.1 * kDensity, kDensity};
  std::normal_distribution<double> normal;
  const auto draw = [&](double sigma) {
    const double x = normal(rng_), y = normal(rng_), z = normal(rng_);
    return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
  };
  const std::vector<ImuSample> clean = Record(kRateHz, 1, {});
  const auto exact = Preintegrate(clean, 0, 500'000'000, {}, noise, kLongestStepS);
  ASSERT_TRUE(exact);
  double sum = 0;
  constexpr int kDraws = 300;
  for (int i = 0; i < kDraws; ++i) {
    std::vector<ImuSample> samples = clean;
    for (ImuSample& sample : samples) {
      sample.gyro_radps += draw(noise.gyro * std::sqrt(kRateHz));
      sample.accel_mps2 += draw(noise.accel * std::sqrt(kRateHz));
    }
    const auto noisy = Preintegrate(samples, 0, 500'000'000, {}, noise, kLongestStepS);
    ASSERT_TRUE(noisy);
    Eigen::Matrix<double, 9, 1> error;
    error << LogSo3(exact->rotation.conjugate() * noisy->rotation),
        noisy->velocity_mps - exact->velocity_mps, noisy->position_m - exact->position_m;
    sum += error.dot(exact->covariance.llt().solve(error)) / 9;
  }
  EXPECT_NEAR(sum / kDraws, 1, 0.1);
}

TEST_F(Imu, SaysNothingOfWhatItDoesNotCover) {
  std::vector<ImuSample> samples = Record(100, 1, {});
  const auto over = [&](double from_s, double to_s) {
    return Preintegrate(samples, std::llround(1e9 * from_s), std::llround(1e9 * to_s), {}, {},
                        kLongestStepS)
        .has_value();
  };
  EXPECT_TRUE(over(0, 1));
  EXPECT_FALSE(over(-0.001, 0.5));
  EXPECT_FALSE(over(0.5, 1.001));
  EXPECT_FALSE(over(0.5, 0.5));
  samples.erase(samples.begin() + 40, samples.begin() + 55);
  EXPECT_FALSE(over(0.2, 0.8));
  EXPECT_FALSE(over(0.45, 0.8));
  EXPECT_TRUE(over(0.56, 0.8));
  EXPECT_FALSE(Preintegrate({}, 0, 10, {}, {}, kLongestStepS));
}

}  // namespace
}  // namespace tagtwist::internal::imu_residual_test
