#include "estimator/trajectory.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "estimator/seeding.h"
#include "frontend/types/so3.h"

namespace tagtwist {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Process covariance of one axis, unit density: [dt^3/3, dt^2/2; dt^2/2, dt].
Eigen::Matrix2d ProcessCovariance(double dt_s) {
  Eigen::Matrix2d q;
  q << dt_s * dt_s * dt_s / 3, dt_s * dt_s / 2, dt_s * dt_s / 2, dt_s;
  return q;
}

// One axis of the interpolation between two states: value = lambda first + psi second, plus noise
// of `conditional` times the density.
struct Interpolator {
  Eigen::Matrix2d lambda, psi, conditional;
  Interpolator(double tau_s, double dt_s) {
    const auto transition = [](double s) { return (Eigen::Matrix2d() << 1, s, 0, 1).finished(); };
    const Eigen::Matrix2d q_tau = ProcessCovariance(tau_s);
    psi = q_tau * transition(dt_s - tau_s).transpose() * ProcessCovariance(dt_s).inverse();
    lambda = transition(tau_s) - psi * transition(dt_s);
    conditional = q_tau - psi * transition(dt_s - tau_s) * q_tau;
  }
};

// [a I, b I; c I, d I] of 3 x 3 blocks.
Matrix6 Kron3(const Eigen::Matrix2d& m) {
  Matrix6 out;
  const Eigen::Matrix3d eye = Eigen::Matrix3d::Identity();
  out << m(0, 0) * eye, m(0, 1) * eye, m(1, 0) * eye, m(1, 1) * eye;
  return out;
}

// The error state's order is theta, p, v, omega: rows of the angular pair (theta, omega) and of the
// linear pair (p, v).
constexpr int kAngularRows[2] = {0, 9}, kLinearRows[2] = {3, 6};

// Adds a 6 x 6 matrix over a pair of 3-vectors into a 12-row matrix.
template <typename Matrix>
void AddPair(const Matrix6& pair, const int (&rows)[2], const int (&columns)[2], int column_shift,
             Matrix* out) {
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      out->template block<3, 3>(rows[i], column_shift + columns[j]) +=
          pair.template block<3, 3>(3 * i, 3 * j);
    }
  }
}

// Rotation part between states 1 and 2 in the local variable xi = Log(R_1' R), with derivatives.
struct AngularInterpolation {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d omega;
  Matrix6 d_first, d_second;  // of (theta, omega) by (theta, omega) of each state
  Matrix6 d_local;            // of (theta, omega) by (xi, dxi/dt): carries the conditional noise
};

AngularInterpolation InterpolateAngular(const BodyState& first, const BodyState& second,
                                        const Interpolator& w) {
  const Eigen::Vector3d phi =
      LogSo3(first.world_from_body.rotation().conjugate() * second.world_from_body.rotation());
  const Eigen::Matrix3d jr_inverse = RightJacobianInverseSo3(phi);
  const Eigen::Vector3d &omega1 = first.twist.omega_body, &omega2 = second.twist.omega_body;
  const Eigen::Vector3d rate2 = jr_inverse * omega2;  // dxi/dt at state 2
  const Eigen::Vector3d xi = w.lambda(0, 1) * omega1 + w.psi(0, 0) * phi + w.psi(0, 1) * rate2;
  const Eigen::Vector3d xi_rate = w.lambda(1, 1) * omega1 + w.psi(1, 0) * phi + w.psi(1, 1) * rate2;
  const Eigen::Matrix3d jr = RightJacobianSo3(xi), eye = Eigen::Matrix3d::Identity();

  AngularInterpolation out;
  out.rotation = first.world_from_body.rotation() * ExpSo3(xi);
  out.omega = jr * xi_rate;
  // omega = Jr(xi) xi_rate; from Jr^-1(xi) omega = xi_rate: d omega = Jr (d xi_rate - D d xi).
  out.d_local.setZero();
  out.d_local.topLeftCorner<3, 3>() = jr;
  out.d_local.bottomLeftCorner<3, 3>() = -jr * DRightJacobianInverseTimesVector(xi, out.omega);
  out.d_local.bottomRightCorner<3, 3>() = jr;
  // Local variables of state 2, (phi, rate2), by both states' errors.
  const Eigen::Matrix3d d_rate2_d_phi = DRightJacobianInverseTimesVector(phi, omega2);
  Matrix6 local2_by_first = Matrix6::Zero(), local2_by_second = Matrix6::Zero();
  local2_by_first.topLeftCorner<3, 3>() = -jr_inverse.transpose();
  local2_by_first.bottomLeftCorner<3, 3>() = -d_rate2_d_phi * jr_inverse.transpose();
  local2_by_second.topLeftCorner<3, 3>() = jr_inverse;
  local2_by_second.bottomLeftCorner<3, 3>() = d_rate2_d_phi * jr_inverse;
  local2_by_second.bottomRightCorner<3, 3>() = jr_inverse;
  const Matrix6 psi = Kron3(w.psi);
  Matrix6 local_by_first = psi * local2_by_first;
  local_by_first.topRightCorner<3, 3>() += w.lambda(0, 1) * eye;
  local_by_first.bottomRightCorner<3, 3>() += w.lambda(1, 1) * eye;
  out.d_first = out.d_local * local_by_first;
  out.d_second = out.d_local * (psi * local2_by_second);
  // theta of the result also moves with R_1 itself: R_1 Exp(theta_1) Exp(xi).
  out.d_first.topLeftCorner<3, 3>() += ExpSo3(xi).toRotationMatrix().transpose();
  return out;
}

StateAndCovariance Between(const Trajectory& t, size_t k, int64_t t_ns) {
  const Interpolator w(ToSeconds(t_ns - t.t_ns[k]), ToSeconds(t.t_ns[k + 1] - t.t_ns[k]));
  const BodyState &first = t.states[k], &second = t.states[k + 1];
  const AngularInterpolation angular = InterpolateAngular(first, second, w);

  StateAndCovariance out;
  const Eigen::Vector3d p1 = first.world_from_body.translation();
  const Eigen::Vector3d p2 = second.world_from_body.translation();
  const Eigen::Vector3d &v1 = first.twist.v_world, &v2 = second.twist.v_world;
  const auto linear = [&](int row) -> Eigen::Vector3d {
    return w.lambda(row, 0) * p1 + w.lambda(row, 1) * v1 + w.psi(row, 0) * p2 + w.psi(row, 1) * v2;
  };
  out.state.world_from_body = MakePose(angular.rotation, linear(0));
  out.state.twist = {linear(1), angular.omega};

  Eigen::Matrix<double, 12, 24> jacobian = Eigen::Matrix<double, 12, 24>::Zero();
  AddPair(Kron3(w.lambda), kLinearRows, kLinearRows, 0, &jacobian);
  AddPair(Kron3(w.psi), kLinearRows, kLinearRows, 12, &jacobian);
  AddPair(angular.d_first, kAngularRows, kAngularRows, 0, &jacobian);
  AddPair(angular.d_second, kAngularRows, kAngularRows, 12, &jacobian);
  Eigen::Matrix<double, 24, 24> joint;
  joint << t.covariances[k], t.cross_covariances[k].transpose(), t.cross_covariances[k],
      t.covariances[k + 1];
  out.covariance = jacobian * joint * jacobian.transpose();
  AddPair(t.accel_psd * Kron3(w.conditional), kLinearRows, kLinearRows, 0, &out.covariance);
  AddPair(
      t.angular_accel_psd * angular.d_local * Kron3(w.conditional) * angular.d_local.transpose(),
      kAngularRows, kAngularRows, 0, &out.covariance);
  return out;
}

}  // namespace

StateAndCovariance Extrapolate(const StateAndCovariance& from, double dt_s, double accel_psd,
                               double angular_accel_psd) {
  StateAndCovariance out;
  out.state = Predict(from.state, dt_s);
  const Eigen::Vector3d turn = dt_s * from.state.twist.omega_body;
  StateCovariance jacobian = StateCovariance::Identity();
  jacobian.block<3, 3>(0, 0) = ExpSo3(turn).toRotationMatrix().transpose();
  jacobian.block<3, 3>(0, 9) = dt_s * RightJacobianSo3(turn);
  jacobian.block<3, 3>(3, 6) = dt_s * Eigen::Matrix3d::Identity();
  out.covariance = jacobian * from.covariance * jacobian.transpose();
  // The noise runs the other way in time when dt_s < 0: the cross terms change sign with it.
  Eigen::Matrix2d q = ProcessCovariance(std::abs(dt_s));
  if (dt_s < 0) q(0, 1) = q(1, 0) = -q(0, 1);
  AddPair(accel_psd * Kron3(q), kLinearRows, kLinearRows, 0, &out.covariance);
  AddPair(angular_accel_psd * Kron3(q), kAngularRows, kAngularRows, 0, &out.covariance);
  return out;
}

std::optional<StateAndCovariance> Trajectory::At(int64_t query_ns) const {
  if (states.empty()) return std::nullopt;
  const auto end_state = [&](size_t k) {
    return Extrapolate({states[k], covariances[k]}, ToSeconds(query_ns - t_ns[k]), accel_psd,
                       angular_accel_psd);
  };
  if (query_ns <= t_ns.front()) return end_state(0);
  if (query_ns >= t_ns.back()) return end_state(t_ns.size() - 1);
  const auto after = std::upper_bound(t_ns.begin(), t_ns.end(), query_ns);
  return Between(*this, static_cast<size_t>(after - t_ns.begin()) - 1, query_ns);
}

}  // namespace tagtwist
