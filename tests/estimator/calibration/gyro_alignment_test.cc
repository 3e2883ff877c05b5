#include "estimator/calibration/gyro_alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "frontend/base/statistics/chi_square.h"
#include "frontend/types/so3.h"
#include "tests/support/draws.h"

namespace tagtwist::internal::gyro_alignment_test {
namespace {

const Eigen::Quaterniond kCamFromImu = ExpSo3({1.2, -0.9, 0.4});
const Eigen::Vector3d kBias(0.02, -0.01, 0.005);
constexpr double kOffsetS = 0.037, kCamSigmaRad = 1e-3, kGyroSigma = 2e-3;

Eigen::Quaterniond AttitudeAt(double t, bool one_axis) {
  const Eigen::Vector3d tilt(0.4 * std::sin(1.3 * t), 0.3 * std::sin(1.7 * t + 1), 0);
  const Eigen::Vector3d heading(0, 0, 0.8 * std::sin(0.9 * t));
  return one_axis ? ExpSo3(heading) : ExpSo3(heading) * ExpSo3(tilt);
}

struct Recording {
  std::vector<TimedRotation> camera;
  std::vector<ImuSample> imu;
};

// 20 s: frames at 15 Hz, the gyro at 200 Hz.
Recording Draw(unsigned seed, bool one_axis = false) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal(0, 1);
  const auto noise = [&](double sigma) -> Eigen::Vector3d {
    return sigma * DrawVector<3>(normal, rng);
  };
  Recording out;
  for (int i = 0; i < 300; ++i) {
    const double t = 1 + i / 15.0;
    out.camera.push_back(
        {std::llround(1e9 * t), AttitudeAt(t, one_axis) * ExpSo3(noise(kCamSigmaRad))});
  }
  for (double t = 0.5; t < 22; t += 0.005) {
    constexpr double kStep = 1e-4;
    const double at = t - kOffsetS;
    const Eigen::Vector3d rate =
        LogSo3(AttitudeAt(at - kStep, one_axis).conjugate() * AttitudeAt(at + kStep, one_axis)) /
        (2 * kStep);
    ImuSample sample;
    sample.t_ns = std::llround(1e9 * t);
    sample.gyro_radps = kCamFromImu.conjugate() * rate + kBias + noise(kGyroSigma);
    out.imu.push_back(sample);
  }
  return out;
}

Eigen::Matrix<double, 7, 1> Error(const GyroAlignment& found) {
  Eigen::Matrix<double, 7, 1> out;
  out << LogSo3(kCamFromImu.conjugate() * found.cam_from_imu), found.bias_radps - kBias,
      found.time_offset_s - kOffsetS;
  return out;
}

TEST(GyroAlignment, FindsMountBiasAndClockWithinItsSigmas) {
  constexpr int kSeeds = 20;
  double nees = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const Recording recording = Draw(seed);
    const auto found = AlignGyro(recording.camera, recording.imu);
    ASSERT_TRUE(found) << found.error().message;
    const Eigen::Matrix<double, 7, 1> error = Error(*found);
    for (int i = 0; i < 7; ++i) {
      EXPECT_LT(std::abs(error(i)), 4 * std::sqrt(found->covariance(i, i))) << "entry " << i;
    }
    EXPECT_LT(std::sqrt(found->covariance(6, 6)), 0.002);
    nees += error.dot(found->covariance.ldlt().solve(error));
  }
  const auto [low, high] = MeanChiSquareBand(7, kSeeds);
  EXPECT_GT(nees / kSeeds, low);
  EXPECT_LT(nees / kSeeds, high);
}

TEST(GyroAlignment, WrongFramesAreSurvived) {
  Recording recording = Draw(3);
  for (const size_t i : {40U, 120U, 200U}) {
    recording.camera[i].world_from_cam = recording.camera[i].world_from_cam * ExpSo3({0, 0.3, 0});
  }
  const auto found = AlignGyro(recording.camera, recording.imu);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_LT(Error(*found).head<3>().norm(), 0.01);
  EXPECT_LT(std::abs(Error(*found)(6)), 0.003);
}

TEST(GyroAlignment, WhatLeavesTheMountOpenIsRefused) {
  const Recording one_axis = Draw(2, true);
  std::vector<TimedRotation> still = one_axis.camera;
  EXPECT_FALSE(AlignGyro({one_axis.camera.begin(), one_axis.camera.begin() + 10}, one_axis.imu));
  EXPECT_FALSE(AlignGyro(one_axis.camera, {}));
  for (TimedRotation& frame : still) frame.world_from_cam.setIdentity();
  EXPECT_FALSE(AlignGyro(still, one_axis.imu));
}

}  // namespace
}  // namespace tagtwist::internal::gyro_alignment_test
