#include "estimator/motion/fast_vibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "estimator/batch/batch.h"
#include "frontend/types/nees.h"
#include "frontend/types/so3.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal::fast_vibration_test {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr double kSigmaM = 0.3e-3, kSigmaRad = 0.5e-3;

using Path = std::function<Eigen::Vector3d(double t_s)>;

Eigen::Vector3d Hand(double t_s) {
  return {0.05 * std::sin(4 * t_s), 0.04 * std::sin(3 * t_s + 1), 0.03 * std::sin(5 * t_s)};
}

// A tenth of the position as a turn.
FastVibration Follow(const Path& path, double rate_hz, int n_frames) {
  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    return Eigen::Vector3d(sigma * normal(rng), sigma * normal(rng), sigma * normal(rng));
  };
  FastVibration out;
  for (int k = 0; k < n_frames; ++k) {
    const double t_s = k / rate_hz;
    PoseMeasurement pose;
    pose.world_from_body =
        MakePose(ExpSo3(0.1 * path(t_s) + noise(kSigmaRad)), path(t_s) + noise(kSigmaM));
    pose.position_covariance = kSigmaM * kSigmaM * Eigen::Matrix3d::Identity();
    pose.attitude_covariance = kSigmaRad * kSigmaRad * Eigen::Matrix3d::Identity();
    out.Add(1'000'000'000 + static_cast<int64_t>(std::llround(1e9 * t_s)), pose);
  }
  return out;
}

Path Vibrating(double amplitude_m, double hz, double until_s = 1e9) {
  return [=](double t_s) -> Eigen::Vector3d {
    const double x = t_s < until_s ? amplitude_m * std::sin(kTwoPi * hz * t_s) : 0;
    return Hand(t_s) + Eigen::Vector3d(0.6, 0, 0.8) * x;
  };
}

TEST(FastVibration, WidensTheTwistByWhatAVibrationMayMove) {
  constexpr double kAmplitudeM = 2e-3;
  for (const double hz : {20.0, 40.0, 49.0, 69.0, 79.0}) {
    const FastVibration vibration = Follow(Vibrating(kAmplitudeM, hz), 30, 200);
    // Of three axes a coordinate's mean square, at the rate in the middle of those that may be.
    const double expected = kAmplitudeM * kAmplitudeM / 6 * std::pow(kTwoPi * 58, 2);
    EXPECT_GT(vibration.variances()(6), 0.5 * expected) << hz;
    EXPECT_LT(vibration.variances()(6), 2 * expected) << hz;
    EXPECT_GT(vibration.variances()(9), 0) << hz;
    EXPECT_EQ(vibration.variances().head<6>().norm(), 0) << hz;
  }
}

TEST(FastVibration, LeavesWhatFramesShow) {
  EXPECT_TRUE(Follow(Hand, 30, 200).variances().isZero());
  EXPECT_TRUE(Follow(Hand, 5, 200).variances().isZero()) << "slow frames";
  const Path walk = [](double t_s) -> Eigen::Vector3d {
    const double a = kTwoPi * 1.9 * t_s;
    return {0.4 * t_s, 0.02 * std::sin(0.5 * a),
            0.025 * std::sin(a) + 0.008 * std::sin(2 * a + 1) + 0.003 * std::sin(4 * a + 2)};
  };
  EXPECT_TRUE(Follow(walk, 30, 200).variances().isZero());
  EXPECT_TRUE(Follow(Vibrating(2e-3, 40), 1000, 400).variances().isZero()) << "frames show it";
}

TEST(FastVibration, EndsWhenItIsOver) {
  EXPECT_FALSE(Follow(Vibrating(2e-3, 40, 4), 30, 119).variances().isZero());
  EXPECT_TRUE(Follow(Vibrating(2e-3, 40, 4), 30, 190).variances().isZero());
}

TEST(FastVibration, IsInTheCovariancesOfABatch) {
  const EstimatorSetup setup = CourseSetup();
  const Path path = Vibrating(3e-3, 70);
  const auto pose_at = [&](double t_s) {
    return MakePose(ExpSo3(0.3 * path(t_s)), Eigen::Vector3d(1.6, 1.4, 1.2) + path(t_s));
  };
  std::vector<BodyState> truth;
  std::vector<FrameMeasurements> measurements;
  for (int k = 0; k < 100; ++k) {
    FrameMeasurements m;
    m.t_ns = static_cast<int64_t>(std::llround(1e9 * k / 30.0));
    truth.push_back(StateAlong(pose_at, k / 30.0));
    m.tags = SeeTags(setup.map, setup.camera,
                     setup.cam_from_body * Inverse(truth.back().world_from_body), 0.15,
                     static_cast<unsigned>(k));
    measurements.push_back(std::move(m));
  }
  const auto estimate = RunBatch(CourseSetUp(), {}, measurements);
  ASSERT_TRUE(estimate) << estimate.error().message;
  double nees = 0;
  int beyond = 0;
  for (size_t k = 0; k < truth.size(); ++k) {
    const FrameEstimate& frame = estimate->frames[k];
    nees += Nees(truth[k], frame.state, frame.covariance, kWholeState).value_or(1e9) / 12;
    beyond += IsBeyondFiveSigma(truth[k], frame) ? 1 : 0;
  }
  EXPECT_GT(nees, 0.4 * static_cast<double>(truth.size()));
  EXPECT_LT(nees, 2.0 * static_cast<double>(truth.size()));
  EXPECT_LE(beyond, 1);
}

}  // namespace
}  // namespace tagtwist::internal::fast_vibration_test
