#pragma once
#include <ceres/sized_cost_function.h>

namespace tagtwist {

/// White noise on acceleration between two states dt apart, whitened, 12x1. The body moves at
/// constant v_world and constant rate, on R^3 x SO(3) (Barfoot, State Estimation for Robotics, ch.
/// 11; Anderson and Barfoot 2015), up to
///   e_theta = phi - dt omega_1,             e_omega = Jr^-1(phi) omega_2 - omega_1,
///   e_p     = p_2 - p_1 - dt v_1,           e_v     = v_2 - v_1,
/// with phi = Log(R_1' R_2) and Jr the right Jacobian of SO(3). Each pair of 3-vectors has the
/// covariance psd [dt^3/3 I, dt^2/2 I; dt^2/2 I, dt I]; its inverse square root is W =
/// [sqrt(12) dt^-1.5, -sqrt(3) dt^-0.5; 0, dt^-0.5] / sqrt(psd).
/// Rows: 0..5 W (e_theta, e_omega), 6..11 W (e_p, e_v): the angular part, then the linear one.
/// Blocks: world_from_body 1 (Pose::params, PoseManifold), twist 1 [v_world; omega_body], then the
/// same of state 2. Holds for rotations between the states below pi.
class ConstantVelocityResidual final : public ceres::SizedCostFunction<12, 7, 6, 7, 6> {
 public:
  /// dt_s > 0; densities [(m/s^2)^2/Hz] and [(rad/s^2)^2/Hz], > 0.
  ConstantVelocityResidual(double dt_s, double accel_psd, double angular_accel_psd);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  double dt_s_;
  double w_angular_, w_linear_;  // 1 / sqrt(psd)
};

}  // namespace tagtwist
