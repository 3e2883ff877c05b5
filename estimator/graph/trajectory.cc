#include "estimator/graph/trajectory.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "estimator/graph/noise_model.h"
#include "frontend/types/so3.h"

namespace tagtwist {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Matrix6x9 = Eigen::Matrix<double, 6, 9>;
constexpr int kSize = kBlockSize;

// An axis of the result, mean = lambda first + psi second, with that much variance given both.
struct Interpolator {
  Eigen::Matrix3d lambda, psi, conditional;
};

// Between two states dt_s apart, tau_s after the first: the informations of both ways added, which
// loses nothing where one of them is long and the other short; a difference of covariances does.
Interpolator Inside(const MotionPrior& prior, double tau_s, double dt_s) {
  if (tau_s <= 0)
    return {Transition(prior.on, 0), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
  const double rest_s = dt_s - tau_s;
  const Eigen::Matrix3d root_onward = RootInformation(prior, rest_s);
  Eigen::Matrix<double, 6, 3> roots;
  roots << RootInformation(prior, tau_s), root_onward * Transition(prior.on, rest_s);
  const Eigen::Matrix3d triangle = Eigen::HouseholderQR<Eigen::Matrix<double, 6, 3>>(roots)
                                       .matrixQR()
                                       .topRows<3>()
                                       .triangularView<Eigen::Upper>();
  const Eigen::Matrix3d root =
      triangle.triangularView<Eigen::Upper>().solve(Eigen::Matrix3d::Identity());
  Interpolator w;
  w.conditional = root * root.transpose();
  w.psi = root * (roots.bottomRows<3>() * root).transpose() * root_onward;
  w.lambda = Transition(prior.on, tau_s) - w.psi * Transition(prior.on, dt_s);
  return w;
}

// tau_s after the last state or, negative, before the first one. The noise then runs the other way
// in time: odd derivatives change their sign.
Interpolator Outside(const MotionPrior& prior, double tau_s) {
  Interpolator w;
  w.lambda = Transition(prior.on, tau_s);
  w.psi.setZero();
  const Eigen::Vector3d sign(1, tau_s < 0 ? -1 : 1, 1);
  w.conditional = sign.asDiagonal() * ProcessCovariance(prior, std::abs(tau_s)) * sign.asDiagonal();
  return w;
}

// The first two rows of an axis matrix, each entry times I.
Matrix6x9 Kron3(const Eigen::Matrix3d& m) {
  Matrix6x9 out;
  const Eigen::Matrix3d eye = Eigen::Matrix3d::Identity();
  out << m(0, 0) * eye, m(0, 1) * eye, m(0, 2) * eye, m(1, 0) * eye, m(1, 1) * eye, m(1, 2) * eye;
  return out;
}

// Where (theta, omega, alpha) and (p, v, a) lie in the error state.
constexpr int kAngularRows[3] = {0, 9, 15}, kLinearRows[3] = {3, 6, 12};

// Adds a matrix of two block rows, and as many block columns as it has, into one of error states.
template <typename Matrix, typename Out>
void AddPart(const Matrix& part, const int (&rows)[3], int column_shift, Out* out) {
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < static_cast<int>(part.cols()) / 3; ++j) {
      out->template block<3, 3>(rows[i], column_shift + rows[j]) +=
          part.template block<3, 3>(3 * i, 3 * j);
    }
  }
}

// Rotation part in the local variable xi = Log(R_1' R), with derivatives.
struct AngularPart {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d omega;
  Matrix6x9 d_first, d_second;  // of (theta, omega) by (theta, omega, alpha) of each state
  Matrix6 d_local;              // of (theta, omega) by (xi, dxi/dt): carries the conditional noise
};

AngularPart InterpolateAngular(const GraphState& first, const GraphState& second,
                               const Interpolator& w) {
  const Eigen::Vector3d phi = Difference(second.pose, first.pose).head<3>();
  const Eigen::Matrix3d jr_inverse = RightJacobianInverseSo3(phi);
  const Eigen::Vector3d omega1 = first.rates.segment<3>(3), alpha1 = first.rates.segment<3>(9);
  const Eigen::Vector3d omega2 = second.rates.segment<3>(3), alpha2 = second.rates.segment<3>(9);
  const auto local = [&](int row) -> Eigen::Vector3d {
    return w.lambda(row, 1) * omega1 + w.lambda(row, 2) * alpha1 + w.psi(row, 0) * phi +
           jr_inverse * (w.psi(row, 1) * omega2 + w.psi(row, 2) * alpha2);
  };
  const Eigen::Vector3d xi = local(0), xi_rate = local(1);
  const Eigen::Matrix3d jr = RightJacobianSo3(xi);

  AngularPart out;
  out.rotation = first.pose.rotation() * ExpSo3(xi);
  out.omega = jr * xi_rate;
  // omega = Jr(xi) xi_rate; from Jr^-1(xi) omega = xi_rate: d omega = Jr (d xi_rate - D d xi).
  out.d_local.setZero();
  out.d_local.topLeftCorner<3, 3>() = jr;
  out.d_local.bottomLeftCorner<3, 3>() = -jr * DRightJacobianInverseTimesVector(xi, out.omega);
  out.d_local.bottomRightCorner<3, 3>() = jr;
  // Local variables of state 2, (phi, Jr^-1 omega2, Jr^-1 alpha2), by both states' errors.
  Eigen::Matrix<double, 9, 3> by_phi;
  by_phi << Eigen::Matrix3d::Identity(), DRightJacobianInverseTimesVector(phi, omega2),
      DRightJacobianInverseTimesVector(phi, alpha2);
  Matrix9 by_first = Matrix9::Zero(), by_second = Matrix9::Zero();
  by_first.leftCols<3>() = -by_phi * jr_inverse.transpose();
  by_second.leftCols<3>() = by_phi * jr_inverse;
  by_second.block<3, 3>(3, 3) = jr_inverse;
  by_second.block<3, 3>(6, 6) = jr_inverse;
  const Matrix6x9 psi = Kron3(w.psi);
  Matrix6x9 local_by_first = Kron3(w.lambda);
  local_by_first.leftCols<3>().setZero();  // xi is measured from state 1: 0 there
  local_by_first += psi * by_first;
  out.d_first = out.d_local * local_by_first;
  out.d_second = out.d_local * (psi * by_second);
  // theta of the result also moves with R_1 itself: R_1 Exp(theta_1) Exp(xi).
  out.d_first.topLeftCorner<3, 3>() += ExpSo3(xi).toRotationMatrix().transpose();
  return out;
}

// The result's state, and how it moves with the two states' errors.
struct Interpolation {
  BodyState state;
  Eigen::Matrix<double, 12, 2 * kSize> jacobian = Eigen::Matrix<double, 12, 2 * kSize>::Zero();
  StateCovariance conditional = StateCovariance::Zero();
};

Interpolation Interpolate(const GraphState& first, const GraphState& second,
                          const Interpolator& linear, const Interpolator& angular) {
  const auto mean = [&](int row) -> Eigen::Vector3d {
    const auto of = [&](const Eigen::Matrix3d& w, const GraphState& s) -> Eigen::Vector3d {
      return w(row, 0) * s.pose.translation() + w(row, 1) * s.rates.segment<3>(0) +
             w(row, 2) * s.rates.segment<3>(6);
    };
    return of(linear.lambda, first) + of(linear.psi, second);
  };
  const AngularPart turn = InterpolateAngular(first, second, angular);
  Interpolation out;
  out.state.world_from_body = MakePose(turn.rotation, mean(0));
  out.state.twist = {mean(1), turn.omega};
  AddPart(Kron3(linear.lambda), kLinearRows, 0, &out.jacobian);
  AddPart(Kron3(linear.psi), kLinearRows, kSize, &out.jacobian);
  AddPart(turn.d_first, kAngularRows, 0, &out.jacobian);
  AddPart(turn.d_second, kAngularRows, kSize, &out.jacobian);
  AddPart(Kron3(linear.conditional).leftCols<6>().eval(), kLinearRows, 0, &out.conditional);
  const Matrix6 noise = Kron3(angular.conditional).leftCols<6>();
  AddPart((turn.d_local * noise * turn.d_local.transpose()).eval(), kAngularRows, 0,
          &out.conditional);
  return out;
}

// J P J' + C by P's root: where the states have far more in common than they leave open between
// them, as positions that no tag tells, the sum of P's products would be rounding, and less than
// none.
template <int kColumns>
StateCovariance Propagated(const Eigen::Matrix<double, 12, kColumns>& jacobian,
                           const Eigen::Matrix<double, kColumns, kColumns>& covariance,
                           const StateCovariance& conditional) {
  const Eigen::LDLT<Eigen::Matrix<double, kColumns, kColumns>> ldlt(covariance);
  Eigen::Matrix<double, kColumns, 12> root = ldlt.transpositionsP() * jacobian.transpose();
  root = (ldlt.matrixU() * root).eval();
  root = (ldlt.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal() * root).eval();
  const StateCovariance out = root.transpose() * root + conditional;
  return 0.5 * (out + out.transpose());
}

}  // namespace

std::optional<StateAndCovariance> Trajectory::At(int64_t t_ns) const {
  if (states.empty()) return std::nullopt;
  const auto scaled = [](const MotionPrior& prior, double scale) {
    return WithDensity(prior, scale * prior.psd);
  };
  const auto at_end = [&](size_t k) -> StateAndCovariance {
    const double tau_s = ToSeconds(t_ns - states[k].t_ns);
    const MotionScale& scale = states[k == 0 && states.size() > 1 ? 1 : k].motion;
    const Interpolation at =
        Interpolate(states[k], states[k], Outside(scaled(linear, scale.linear), tau_s),
                    Outside(scaled(angular, scale.angular), tau_s));
    return {at.state,
            Propagated<kSize>(at.jacobian.leftCols<kSize>(), covariances[k], at.conditional)};
  };
  if (t_ns <= states.front().t_ns) return at_end(0);
  if (t_ns >= states.back().t_ns) return at_end(states.size() - 1);
  const auto after =
      std::upper_bound(states.begin(), states.end(), t_ns,
                       [](int64_t t, const GraphState& state) { return t < state.t_ns; });
  const auto k = static_cast<size_t>(after - states.begin()) - 1;
  const double tau_s = ToSeconds(t_ns - states[k].t_ns);
  const double dt_s = ToSeconds(states[k + 1].t_ns - states[k].t_ns);
  const MotionScale& scale = states[k + 1].motion;
  const auto over = [&](const MotionPrior& prior, double by) {
    return scale.breaks ? internal::PriorOverBreak(prior, dt_s) : scaled(prior, by);
  };
  const Interpolation at =
      Interpolate(states[k], states[k + 1], Inside(over(linear, scale.linear), tau_s, dt_s),
                  Inside(over(angular, scale.angular), tau_s, dt_s));
  Eigen::Matrix<double, 2 * kSize, 2 * kSize> joint;
  joint << covariances[k], cross_covariances[k].transpose(), cross_covariances[k],
      covariances[k + 1];
  return StateAndCovariance{at.state, Propagated<2 * kSize>(at.jacobian, joint, at.conditional)};
}

}  // namespace tagtwist
