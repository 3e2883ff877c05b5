#include "residuals/constant_velocity_residual.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "frontend/types/so3.h"
#include "residuals/pose_manifold.h"

namespace tagtwist {
namespace {

using Matrix12x6 = Eigen::Matrix<double, 12, 6>;

// The upper triangular square root of the inverse of [dt^3/3, dt^2/2; dt^2/2, dt].
struct Whitener {
  double a, b, c;
  explicit Whitener(double dt_s)
      : a(std::sqrt(12.0 / dt_s) / dt_s), b(-std::sqrt(3.0 / dt_s)), c(std::sqrt(1.0 / dt_s)) {}
};

// Rows of a 6-row block: [a top + b bottom; c bottom] * scale.
template <typename Top, typename Bottom, typename Out>
void WhitenPair(const Whitener& w, double scale, const Top& top, const Bottom& bottom, Out&& out) {
  out.template topRows<3>() = scale * (w.a * top + w.b * bottom);
  out.template bottomRows<3>() = scale * w.c * bottom;
}

void LiftPoseJacobian(const Matrix12x6& d_residual_d_tangent, const double* pose, double* out) {
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift;
  PoseManifold().MinusJacobian(pose, lift.data());
  Eigen::Map<Eigen::Matrix<double, 12, 7, Eigen::RowMajor>>(out).noalias() =
      d_residual_d_tangent * lift;
}

}  // namespace

ConstantVelocityResidual::ConstantVelocityResidual(double dt_s, double accel_psd,
                                                   double angular_accel_psd)
    : dt_s_(dt_s),
      w_angular_(1.0 / std::sqrt(angular_accel_psd)),
      w_linear_(1.0 / std::sqrt(accel_psd)) {}

bool ConstantVelocityResidual::Evaluate(double const* const* parameters, double* residuals,
                                        double** jacobians) const {
  const Eigen::Map<const Eigen::Quaterniond> q1(parameters[0]), q2(parameters[2]);
  const Eigen::Map<const Eigen::Vector3d> p1(parameters[0] + 4), p2(parameters[2] + 4);
  const Eigen::Map<const Eigen::Vector3d> v1(parameters[1]), v2(parameters[3]);
  const Eigen::Map<const Eigen::Vector3d> omega1(parameters[1] + 3), omega2(parameters[3] + 3);
  const Eigen::Vector3d phi = LogSo3(q1.conjugate() * q2);
  const Eigen::Matrix3d jr_inverse = RightJacobianInverseSo3(phi);

  const Whitener w(dt_s_);
  Eigen::Map<Eigen::Matrix<double, 12, 1>> r(residuals);
  WhitenPair(w, w_angular_, phi - dt_s_ * omega1, jr_inverse * omega2 - omega1, r.head<6>());
  WhitenPair(w, w_linear_, p2 - p1 - dt_s_ * v1, v2 - v1, r.tail<6>());
  if (jacobians == nullptr) return true;

  const Eigen::Matrix3d eye = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d d_rate_d_phi = DRightJacobianInverseTimesVector(phi, omega2);
  if (jacobians[0] != nullptr) {
    const Eigen::Matrix3d d_phi = -jr_inverse.transpose();  // -Jl^-1(phi)
    Matrix12x6 d = Matrix12x6::Zero();
    WhitenPair(w, w_angular_, d_phi, d_rate_d_phi * d_phi, d.topLeftCorner<6, 3>());
    d.block<3, 3>(6, 3) = -w_linear_ * w.a * eye;
    LiftPoseJacobian(d, parameters[0], jacobians[0]);
  }
  if (jacobians[1] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 12, 6, Eigen::RowMajor>> d(jacobians[1]);
    d.setZero();
    WhitenPair(w, w_angular_, -dt_s_ * eye, -eye, d.topRightCorner<6, 3>());
    WhitenPair(w, w_linear_, -dt_s_ * eye, -eye, d.bottomLeftCorner<6, 3>());
  }
  if (jacobians[2] != nullptr) {
    Matrix12x6 d = Matrix12x6::Zero();
    WhitenPair(w, w_angular_, jr_inverse, d_rate_d_phi * jr_inverse, d.topLeftCorner<6, 3>());
    d.block<3, 3>(6, 3) = w_linear_ * w.a * eye;
    LiftPoseJacobian(d, parameters[2], jacobians[2]);
  }
  if (jacobians[3] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 12, 6, Eigen::RowMajor>> d(jacobians[3]);
    d.setZero();
    WhitenPair(w, w_angular_, Eigen::Matrix3d::Zero(), jr_inverse, d.topRightCorner<6, 3>());
    WhitenPair(w, w_linear_, Eigen::Matrix3d::Zero(), eye, d.bottomLeftCorner<6, 3>());
  }
  return true;
}

}  // namespace tagtwist
