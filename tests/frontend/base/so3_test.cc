#include "frontend/types/so3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/draws.h"

namespace tagtwist::internal::so3_test {
namespace {

Eigen::Vector3d RandomVector(std::mt19937& rng, double scale) {
  std::uniform_real_distribution<double> u(-1, 1);
  return scale * DrawVector<3>(u, rng).normalized();
}

constexpr double kAngles[] = {0.0, 1e-9, 1e-5, 5e-3, 9.9e-3, 1.01e-2, 0.1, 1.0, 2.5, 3.1};

TEST(So3, LogInvertsExp) {
  std::mt19937 rng(1);
  for (const double angle : kAngles) {
    const Eigen::Vector3d theta = RandomVector(rng, angle);
    EXPECT_LT((LogSo3(ExpSo3(theta)) - theta).norm(), 1e-13) << angle;
    Eigen::Quaterniond negative = ExpSo3(theta);
    negative.coeffs() *= -1;
    EXPECT_LT((LogSo3(negative) - theta).norm(), 1e-13) << angle;
  }
}

TEST(So3, RightJacobianMatchesNumericDerivative) {
  std::mt19937 rng(2);
  for (const double angle : kAngles) {
    const Eigen::Vector3d theta = RandomVector(rng, angle), d = RandomVector(rng, 1e-6);
    const Eigen::Vector3d moved = LogSo3(ExpSo3(theta).conjugate() * ExpSo3(theta + d)) -
                                  LogSo3(ExpSo3(theta).conjugate() * ExpSo3(theta - d));
    EXPECT_LT((moved / 2 - RightJacobianSo3(theta) * d).norm(), 1e-14) << angle;
  }
}

TEST(So3, InverseJacobianIsTheInverse) {
  std::mt19937 rng(3);
  for (const double angle : kAngles) {
    const Eigen::Vector3d theta = RandomVector(rng, angle);
    EXPECT_LT(
        (RightJacobianInverseSo3(theta) * RightJacobianSo3(theta) - Eigen::Matrix3d::Identity())
            .norm(),
        1e-11)
        << angle;
  }
}

TEST(So3, DerivativeOfInverseJacobianTimesVectorMatchesNumericOne) {
  std::mt19937 rng(4);
  for (const double angle : kAngles) {
    const Eigen::Vector3d theta = RandomVector(rng, angle), v = RandomVector(rng, 2.0);
    const Eigen::Matrix3d analytic = DRightJacobianInverseTimesVector(theta, v);
    Eigen::Matrix3d numeric;
    constexpr double kStep = 1e-5;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d h = kStep * Eigen::Vector3d::Unit(i);
      numeric.col(i) =
          (RightJacobianInverseSo3(theta + h) * v - RightJacobianInverseSo3(theta - h) * v) /
          (2 * kStep);
    }
    EXPECT_LT((analytic - numeric).norm(), 1e-7) << angle << "\n" << analytic - numeric;
    EXPECT_GT(analytic.norm(), 0.5);
  }
}

}  // namespace
}  // namespace tagtwist::internal::so3_test
