#pragma once
#include <ceres/sized_cost_function.h>

#include <Eigen/Core>
#include <array>

#include "residuals/motion_prior.h"

namespace tagtwist::internal {

/// Motion prior between two states dt apart, whitened, 18x1, on R^3 x SO(3): constant v_world and
/// rate under white noise on acceleration, constant acceleration under white noise on jerk, apart
/// for the linear and the angular part (Barfoot, State Estimation for Robotics, ch. 11; Anderson
/// and Barfoot 2015; Tang, Yoon and Barfoot 2019). An axis has the errors e = x_2 - F x_1, F =
/// Transition(dt). The linear part's states are x = [p, v, a] in W. The angular part's are those
/// of the local variable xi(t) = Log(R_1' R(t)):
///   x_1 = [0, omega_1, alpha_1],   x_2 = [phi, Jr^-1(phi) omega_2, Jr^-1(phi) alpha_2],
/// with phi = Log(R_1' R_2) and Jr the right Jacobian of SO(3); alpha is by that definition the
/// angular acceleration, but for terms of second order in the turn between the states.
/// Rows: 0..8 W (e_theta, e_omega, e_alpha), 9..17 W (e_p, e_v, e_a); W = RootInformation(dt).
/// Blocks: world_from_body 1 (Pose::params, PoseManifold), rates 1 [v_world; omega_body; a_world;
/// alpha_body], then the same of state 2. Holds for turns below pi between the states.
class MotionResidual final : public ceres::SizedCostFunction<18, 7, 12, 7, 12> {
 public:
  /// The angular part and the linear one share nothing: nine rows each, which three 3-vectors of
  /// either state enter, here by their column in a state's tangent (18).
  struct Part {
    int first_row;
    std::array<int, 3> columns;
  };
  static constexpr Part kAngular{0, {0, 9, 15}}, kLinear{9, {3, 6, 12}};

  /// dt_s > 0.
  MotionResidual(double dt_s, const MotionPrior& linear, const MotionPrior& angular);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;
  /// Evaluate with the Jacobian in the states' tangents: pose 1 (6), rates 1 (12), pose 2, rates 2.
  void Linearize(double const* const* parameters, Eigen::Matrix<double, 18, 1>* residual,
                 Eigen::Matrix<double, 18, 36>* jacobian) const;

  /// log det of the inverse process covariance of the two parts, three axes each.
  double LogDetInformation() const;

 private:
  Eigen::Matrix<double, 18, 1> Residual(double const* const* parameters, const Eigen::Vector3d& phi,
                                        const Eigen::Matrix3d& jr_inverse) const;
  // Into the columns of both poses; phi and Jr^-1(phi) as above.
  void DifferentiateByPoses(double const* const* parameters, const Eigen::Vector3d& phi,
                            const Eigen::Matrix3d& jr_inverse,
                            Eigen::Matrix<double, 18, 36>* jacobian) const;
  void DifferentiateByRates(const Eigen::Matrix3d& jr_inverse,
                            Eigen::Matrix<double, 18, 36>* jacobian) const;

  Eigen::Matrix3d f_linear_, f_angular_;  // transitions
  Eigen::Matrix3d w_linear_, w_angular_;  // root informations
};

}  // namespace tagtwist::internal
