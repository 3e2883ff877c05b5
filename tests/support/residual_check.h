#pragma once
#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "frontend/types/pose.h"
#include "frontend/types/so3.h"
#include "residuals/pose_manifold.h"

namespace tagtwist::internal {

/// Random values, and a check of Jacobians.
class Residuals : public testing::Test {
 protected:
  double Uniform() { return std::uniform_real_distribution<double>(-1, 1)(rng_); }
  Eigen::Vector3d Vec() { return {Uniform(), Uniform(), Uniform()}; }
  Pose RandomPose(double angle) {
    const Eigen::Vector3d translation = 5 * Vec();
    return MakePose(ExpSo3(angle * Vec().normalized()), translation);
  }

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

}  // namespace tagtwist::internal
