#include "residuals/motion_residual.h"

#include <Eigen/Geometry>
#include <cmath>

#include "frontend/types/so3.h"
#include "residuals/pose_manifold.h"

namespace tagtwist::internal {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Vector18 = Eigen::Matrix<double, 18, 1>;
using Matrix9x3 = Eigen::Matrix<double, 9, 3>;
using Matrix18x36 = Eigen::Matrix<double, 18, 36>;

// Where the parts start in the rows, and the derivatives in a block of rates.
constexpr int kAngularRow = MotionResidual::kAngular.first_row,
              kLinearRow = MotionResidual::kLinear.first_row;
constexpr int kV = 0, kOmega = 3, kA = 6, kAlpha = 9;
// Where the blocks start in the columns of the Jacobian.
constexpr int kPose1 = 0, kRates1 = 6, kPose2 = 18, kRates2 = 24;

// (W x I) column, for a column of three 3 x n blocks.
template <typename Column>
Column Whiten(const Eigen::Matrix3d& w, const Column& column) {
  Column out;
  for (int i = 0; i < 3; ++i) {
    auto row = out.template middleRows<3>(3 * i);
    row = w(i, i) * column.template middleRows<3>(3 * i);
    for (int j = i + 1; j < 3; ++j) row += w(i, j) * column.template middleRows<3>(3 * j);
  }
  return out;
}

// Entry j of the axis state as a column of W (. x I): the derivative by a 3-vector that adds to it.
void SetScaledColumn(const Eigen::Matrix3d& matrix, int j, int row, int column, Matrix18x36* out) {
  for (int i = 0; i < 3; ++i) {
    out->block<3, 3>(row + 3 * i, column).diagonal().setConstant(matrix(i, j));
  }
}

void LiftPoseJacobian(const Eigen::Matrix<double, 18, 6>& d_residual_d_tangent, const double* pose,
                      double* out) {
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift;
  PoseManifold().MinusJacobian(pose, lift.data());
  Eigen::Map<Eigen::Matrix<double, 18, 7, Eigen::RowMajor>>(out).noalias() =
      d_residual_d_tangent * lift;
}

// phi of the header.
Eigen::Vector3d TurnBetween(const double* pose1, const double* pose2) {
  const Eigen::Map<const Eigen::Quaterniond> q1(pose1), q2(pose2);
  return LogSo3(q1.conjugate() * q2);
}

}  // namespace

MotionResidual::MotionResidual(double dt_s, const MotionPrior& linear, const MotionPrior& angular)
    : f_linear_(Transition(linear.on, dt_s)),
      f_angular_(Transition(angular.on, dt_s)),
      w_linear_(RootInformation(linear, dt_s)),
      w_angular_(RootInformation(angular, dt_s)) {}

double MotionResidual::LogDetInformation() const {
  const auto of_part = [](const Eigen::Matrix3d& w) {  // but for what is left free
    const auto roots = w.diagonal().array();
    return (roots > 0).select(roots.log(), 0.0).sum();
  };
  return 6 * (of_part(w_linear_) + of_part(w_angular_));
}

Vector18 MotionResidual::Residual(double const* const* parameters, const Eigen::Vector3d& phi,
                                  const Eigen::Matrix3d& jr_inverse) const {
  using Vector3Map = Eigen::Map<const Eigen::Vector3d>;
  const Vector3Map p1(parameters[0] + 4), p2(parameters[2] + 4);
  const Eigen::Map<const Eigen::Matrix<double, 12, 1>> rates1(parameters[1]), rates2(parameters[3]);
  Vector9 linear, angular;
  linear << p2, rates2.segment<3>(kV), rates2.segment<3>(kA);
  angular << phi, jr_inverse * rates2.segment<3>(kOmega), jr_inverse * rates2.segment<3>(kAlpha);
  for (int i = 0; i < 3; ++i) {
    linear.segment<3>(3 * i) -= f_linear_(i, 0) * p1 + f_linear_(i, 1) * rates1.segment<3>(kV) +
                                f_linear_(i, 2) * rates1.segment<3>(kA);
    angular.segment<3>(3 * i) -=
        f_angular_(i, 1) * rates1.segment<3>(kOmega) + f_angular_(i, 2) * rates1.segment<3>(kAlpha);
  }
  Vector18 out;
  out.segment<9>(kAngularRow) = Whiten(w_angular_, angular);
  out.segment<9>(kLinearRow) = Whiten(w_linear_, linear);
  return out;
}

void MotionResidual::Linearize(double const* const* parameters, Vector18* residual,
                               Matrix18x36* jacobian) const {
  const Eigen::Vector3d phi = TurnBetween(parameters[0], parameters[2]);
  const Eigen::Matrix3d jr_inverse = RightJacobianInverseSo3(phi);
  *residual = Residual(parameters, phi, jr_inverse);
  jacobian->setZero();
  DifferentiateByPoses(parameters, phi, jr_inverse, jacobian);
  DifferentiateByRates(jr_inverse, jacobian);
}

bool MotionResidual::Evaluate(double const* const* parameters, double* residuals,
                              double** jacobians) const {
  Eigen::Map<Vector18> r(residuals);
  if (jacobians == nullptr) {
    const Eigen::Vector3d phi = TurnBetween(parameters[0], parameters[2]);
    r = Residual(parameters, phi, RightJacobianInverseSo3(phi));
    return true;
  }
  Vector18 residual;
  Matrix18x36 jacobian;
  Linearize(parameters, &residual, &jacobian);
  r = residual;
  using RatesJacobian = Eigen::Map<Eigen::Matrix<double, 18, 12, Eigen::RowMajor>>;
  if (jacobians[0]) LiftPoseJacobian(jacobian.middleCols<6>(kPose1), parameters[0], jacobians[0]);
  if (jacobians[1]) RatesJacobian{jacobians[1]} = jacobian.middleCols<12>(kRates1);
  if (jacobians[2]) LiftPoseJacobian(jacobian.middleCols<6>(kPose2), parameters[2], jacobians[2]);
  if (jacobians[3]) RatesJacobian{jacobians[3]} = jacobian.middleCols<12>(kRates2);
  return true;
}

void MotionResidual::DifferentiateByPoses(double const* const* parameters,
                                          const Eigen::Vector3d& phi,
                                          const Eigen::Matrix3d& jr_inverse,
                                          Matrix18x36* jacobian) const {
  const Eigen::Vector3d omega2(parameters[3] + kOmega), alpha2(parameters[3] + kAlpha);
  Matrix9x3 d_phi;
  d_phi << Eigen::Matrix3d::Identity(), DRightJacobianInverseTimesVector(phi, omega2),
      DRightJacobianInverseTimesVector(phi, alpha2);
  const Matrix9x3 whitened = Whiten(w_angular_, d_phi);
  jacobian->block<9, 3>(kAngularRow, kPose1).noalias() =
      whitened * -jr_inverse.transpose();  // -Jl^-1(phi)
  jacobian->block<9, 3>(kAngularRow, kPose2).noalias() = whitened * jr_inverse;
  SetScaledColumn(-w_linear_ * f_linear_, 0, kLinearRow, kPose1 + 3, jacobian);
  SetScaledColumn(w_linear_, 0, kLinearRow, kPose2 + 3, jacobian);
}

void MotionResidual::DifferentiateByRates(const Eigen::Matrix3d& jr_inverse,
                                          Matrix18x36* jacobian) const {
  const Eigen::Matrix3d linear_by = -w_linear_ * f_linear_, angular_by = -w_angular_ * f_angular_;
  SetScaledColumn(linear_by, 1, kLinearRow, kRates1 + kV, jacobian);
  SetScaledColumn(linear_by, 2, kLinearRow, kRates1 + kA, jacobian);
  SetScaledColumn(angular_by, 1, kAngularRow, kRates1 + kOmega, jacobian);
  SetScaledColumn(angular_by, 2, kAngularRow, kRates1 + kAlpha, jacobian);
  SetScaledColumn(w_linear_, 1, kLinearRow, kRates2 + kV, jacobian);
  SetScaledColumn(w_linear_, 2, kLinearRow, kRates2 + kA, jacobian);
  for (int i = 0; i < 3; ++i) {
    const int row = kAngularRow + 3 * i;
    jacobian->block<3, 3>(row, kRates2 + kOmega) = w_angular_(i, 1) * jr_inverse;
    jacobian->block<3, 3>(row, kRates2 + kAlpha) = w_angular_(i, 2) * jr_inverse;
  }
}

}  // namespace tagtwist::internal
