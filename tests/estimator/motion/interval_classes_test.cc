#include "estimator/motion/bank/interval_classes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/support/draws.h"

namespace tagtwist::internal::interval_classes_test {
namespace {

constexpr double kSigmaM = 0.3e-3, kDtS = 1.0 / 30, kJumpS = 1.51;
constexpr int kFrames = 90;

// At rest, then accelerated along x by that.
Eigen::Vector3d At(double t, double acceleration_mps2) {
  return {t < kJumpS ? 0 : 0.5 * acceleration_mps2 * std::pow(t - kJumpS, 2), 0, 0};
}

// Densities over the intervals that end with frames 1 and on; that of frame 0 is none.
std::vector<double> DensitiesFromBothSides(WhiteNoiseOn on, double acceleration_mps2) {
  std::mt19937_64 rng(3);
  std::normal_distribution<double> noise(0, kSigmaM);
  std::vector<Eigen::Vector3d> measured;
  for (int k = 0; k < kFrames; ++k) {
    measured.push_back(At(k * kDtS, acceleration_mps2) + DrawVector<3>(noise, rng));
  }
  const Eigen::Matrix3d covariance = kSigmaM * kSigmaM * Eigen::Matrix3d::Identity();
  MotionBank forwards(LinearBankOptions(on)), backwards(LinearBankOptions(on));
  std::vector<std::vector<MotionBank::Class>> past;
  for (const Eigen::Vector3d& x : measured) {
    if (!past.empty()) forwards.Predict(kDtS);
    past.push_back(forwards.Classes(1e-5));
    forwards.Measure(x, covariance);
  }
  std::vector<double> out(kFrames, 0);
  for (size_t k = kFrames; k-- > 1;) {
    if (k + 1 < kFrames) backwards.Predict(kDtS);
    backwards.Measure(measured[k], covariance);
    out[k] = backwards.DensityOf(WeightsFromBothSides(
        past[k], InForwardTime(backwards.Classes(1e-4), Eigen::Vector3d::Zero()), on, 0.999,
        backwards.size()));
  }
  return out;
}

// Frame 46 is the first after the jump, which no frame before 47 shows. What follows was lively
// just before, and comes to rest slowly.
TEST(IntervalClasses, AJumpOfTheAccelerationIsInTheIntervalInWhichItWas) {
  const std::vector<double> densities = DensitiesFromBothSides(WhiteNoiseOn::kJerk, 3);
  // (3 m/s^2)^2 in a thirtieth of a second, to an order of magnitude.
  EXPECT_GT(densities[46], 27);
  EXPECT_LT(densities[46], 2700);
  EXPECT_EQ(std::max_element(densities.begin(), densities.end()) - densities.begin(), 47);
  for (size_t k = 10; k < 43; ++k) EXPECT_LT(densities[k], 1e-2 * densities[46]) << "frame " << k;
  for (size_t k = 60; k < 80; ++k) EXPECT_LT(densities[k], 1e-3 * densities[46]) << "frame " << k;
}

TEST(IntervalClasses, RestIsAtRestThroughout) {
  for (const WhiteNoiseOn on : {WhiteNoiseOn::kJerk, WhiteNoiseOn::kAcceleration}) {
    const std::vector<double> densities = DensitiesFromBothSides(on, 0);
    for (size_t k = 10; k + 10 < kFrames; ++k) EXPECT_LT(densities[k], 1e-2) << "frame " << k;
  }
}

TEST(IntervalClasses, TheSameAsTheFutureIsLikelierThanAnyOther) {
  MotionBank bank(LinearBankOptions(WhiteNoiseOn::kJerk));
  bank.Measure(Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity());
  std::vector<MotionBank::Class> past = bank.Classes(0), future = {past[5]};
  future[0].weight = 1;
  const std::vector<double> weights =
      WeightsFromBothSides(past, future, WhiteNoiseOn::kJerk, 0.9, bank.size());
  EXPECT_EQ(std::max_element(weights.begin(), weights.end()) - weights.begin(), 5);
  EXPECT_NEAR(weights[5], 0.9, 0.02);
}

TEST(IntervalClasses, TimeTurnsTwiceIntoItself) {
  MotionBank bank(LinearBankOptions(WhiteNoiseOn::kJerk));
  bank.Measure({1, 2, 3}, 1e-6 * Eigen::Matrix3d::Identity());
  bank.Predict(0.1);
  bank.Measure({1.1, 2, 3}, 1e-6 * Eigen::Matrix3d::Identity());
  const std::vector<MotionBank::Class> once = InForwardTime(bank.Classes(0), {4, 5, 6});
  const std::vector<MotionBank::Class> twice = InForwardTime(once, {-4, -5, -6});
  EXPECT_TRUE(once[3].filter.segment<3>(3).isApprox(-bank.Classes(0)[3].filter.segment<3>(3)));
  for (size_t i = 0; i < twice.size(); ++i) {
    EXPECT_LT((twice[i].filter - bank.Classes(0)[i].filter).cwiseAbs().maxCoeff(), 1e-12);
  }
}

}  // namespace
}  // namespace tagtwist::internal::interval_classes_test
