#pragma once
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>

#include "residuals/preintegration.h"

namespace tagtwist::internal {

/// What an IMU with the body's axes, at `l` in the body, says of two states, whitened, 15x1
/// (Forster, Carlone, Dellaert and Scaramuzza 2017, Eq. 45, on R^3 x SO(3)):
///   r_theta = Log((dR Exp(d_bias))' R_1' R_2)
///   r_v = R_1' (v_2 - v_1 - g dt) - dv,   r_p = R_1' (p_2 - p_1 - v_1 dt - g dt^2 / 2) - dp
/// with the IMU's p_i = p_body + R_i l and v_i = v_body + R_i (omega_i x l), and
///   r_gyro, r_accel = bias_2 - bias_1, a random walk,
/// dR, dv, dp of Preintegration, to first order in bias_1 - its bias. The states' accelerations
/// hold the biases instead: [v_world; omega_body; accel bias; gyro bias], under a motion prior
/// that leaves them free (MotionPrior::leaves_third_free).
/// Blocks: world_from_body 1, rates 1, world_from_body 2, rates 2.
class ImuResidual final : public ceres::SizedCostFunction<15, 7, 12, 7, 12> {
 public:
  /// `imu_in_body_m`: where the IMU is. `walk`: how far the biases wander over the interval,
  /// standard deviations [rad/s], [m/s^2], > 0.
  ImuResidual(const Preintegration& motion, const Eigen::Vector3d& imu_in_body_m,
              const Eigen::Vector3d& gravity_world_mps2, double gyro_walk_radps,
              double accel_walk_mps2);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

  /// log det of the inverse covariance that the residual is whitened by.
  double LogDetInformation() const;
  /// Derivatives, 15x3, parameters as of Evaluate: by where the IMU is in the body; by gravity in
  /// W; by a turn of its axes in the body, the biases apart.
  Eigen::Matrix<double, 15, 3> ByPlace(double const* const* parameters) const;
  Eigen::Matrix<double, 15, 3> ByGravity(double const* const* parameters) const;
  Eigen::Matrix<double, 15, 3> ByAxes() const;

 private:
  using Matrix15x6 = Eigen::Matrix<double, 15, 6>;
  using Matrix15x12 = Eigen::Matrix<double, 15, 12>;
  struct Terms;
  Terms TermsOf(double const* const* parameters) const;
  void DifferentiateByFirst(const Terms& terms, Matrix15x6* pose, Matrix15x12* rates) const;
  void DifferentiateBySecond(const Terms& terms, Matrix15x6* pose, Matrix15x12* rates) const;

  Preintegration motion_;
  Eigen::Vector3d place_;  // in the body
  Eigen::Vector3d gravity_;
  Eigen::Matrix<double, 9, 9> root_;  // lower triangular, root' root = covariance^-1
  double gyro_root_, accel_root_;
};

/// What a gyro with the body's axes says of a state: (omega_body + gyro bias - measured) / sigma,
/// 3x1, the states' rates as of ImuResidual.
class GyroRateResidual final : public ceres::SizedCostFunction<3, 12> {
 public:
  /// sigma_radps > 0.
  GyroRateResidual(const Eigen::Vector3d& measured_radps, double sigma_radps)
      : measured_(measured_radps), root_(1 / sigma_radps) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d measured_;
  double root_;
};

/// The biases' random walk alone, where no sample covers an interval: (bias_2 - bias_1) / walk,
/// gyro and accelerometer, 6x1. Blocks: rates 1, rates 2, as of ImuResidual.
class BiasWalkResidual final : public ceres::SizedCostFunction<6, 12, 12> {
 public:
  /// As of ImuResidual.
  BiasWalkResidual(double gyro_walk_radps, double accel_walk_mps2)
      : gyro_root_(1 / gyro_walk_radps), accel_root_(1 / accel_walk_mps2) {}
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
  double LogDetInformation() const;

 private:
  double gyro_root_, accel_root_;
};

}  // namespace tagtwist::internal
