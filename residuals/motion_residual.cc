#include "residuals/motion_residual.h"

#include <Eigen/Geometry>
#include <cmath>

#include "frontend/types/so3.h"
#include "residuals/pose_manifold.h"

namespace tagtwist {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9x3 = Eigen::Matrix<double, 9, 3>;
using Matrix18x6 = Eigen::Matrix<double, 18, 6>;
using Matrix18x12 = Eigen::Matrix<double, 18, 12, Eigen::RowMajor>;

// Where the parts start in the rows, and the derivatives in a block of rates.
constexpr int kAngularRow = 0, kLinearRow = 9;
constexpr int kV = 0, kOmega = 3, kA = 6, kAlpha = 9;

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
void AddScaledColumn(const Eigen::Matrix3d& matrix, int j, int row, int column, Matrix18x12* out) {
  for (int i = 0; i < 3; ++i) {
    out->block<3, 3>(row + 3 * i, column) += matrix(i, j) * Eigen::Matrix3d::Identity();
  }
}

void LiftPoseJacobian(const Matrix18x6& d_residual_d_tangent, const double* pose, double* out) {
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift;
  PoseManifold().MinusJacobian(pose, lift.data());
  Eigen::Map<Eigen::Matrix<double, 18, 7, Eigen::RowMajor>>(out).noalias() =
      d_residual_d_tangent * lift;
}

}  // namespace

MotionResidual::MotionResidual(double dt_s, const MotionPrior& linear, const MotionPrior& angular)
    : f_linear_(Transition(linear.on, dt_s)),
      f_angular_(Transition(angular.on, dt_s)),
      w_linear_(RootInformation(linear, dt_s)),
      w_angular_(RootInformation(angular, dt_s)) {}

double MotionResidual::LogDetInformation() const {
  return 6 * (w_linear_.diagonal().array().log().sum() + w_angular_.diagonal().array().log().sum());
}

bool MotionResidual::Evaluate(double const* const* parameters, double* residuals,
                              double** jacobians) const {
  using Vector3Map = Eigen::Map<const Eigen::Vector3d>;
  const Eigen::Map<const Eigen::Quaterniond> q1(parameters[0]), q2(parameters[2]);
  const Vector3Map p1(parameters[0] + 4), p2(parameters[2] + 4);
  const Eigen::Map<const Eigen::Matrix<double, 12, 1>> rates1(parameters[1]), rates2(parameters[3]);
  const Eigen::Vector3d omega2 = rates2.segment<3>(kOmega), alpha2 = rates2.segment<3>(kAlpha);
  const Eigen::Vector3d phi = LogSo3(q1.conjugate() * q2);
  const Eigen::Matrix3d jr_inverse = RightJacobianInverseSo3(phi);

  Vector9 linear, angular;
  linear << p2, rates2.segment<3>(kV), rates2.segment<3>(kA);
  angular << phi, jr_inverse * omega2, jr_inverse * alpha2;
  for (int i = 0; i < 3; ++i) {
    linear.segment<3>(3 * i) -= f_linear_(i, 0) * p1 + f_linear_(i, 1) * rates1.segment<3>(kV) +
                                f_linear_(i, 2) * rates1.segment<3>(kA);
    angular.segment<3>(3 * i) -=
        f_angular_(i, 1) * rates1.segment<3>(kOmega) + f_angular_(i, 2) * rates1.segment<3>(kAlpha);
  }
  Eigen::Map<Eigen::Matrix<double, 18, 1>> r(residuals);
  r.segment<9>(kAngularRow) = Whiten(w_angular_, angular);
  r.segment<9>(kLinearRow) = Whiten(w_linear_, linear);
  if (jacobians == nullptr) return true;

  DifferentiateByPoses(parameters, phi, jr_inverse, jacobians);
  DifferentiateByRates(jr_inverse, jacobians);
  return true;
}

void MotionResidual::DifferentiateByPoses(double const* const* parameters,
                                          const Eigen::Vector3d& phi,
                                          const Eigen::Matrix3d& jr_inverse,
                                          double** jacobians) const {
  if (jacobians[0] == nullptr && jacobians[2] == nullptr) return;
  const Eigen::Vector3d omega2(parameters[3] + kOmega), alpha2(parameters[3] + kAlpha);
  Matrix9x3 d_phi;
  d_phi << Eigen::Matrix3d::Identity(), DRightJacobianInverseTimesVector(phi, omega2),
      DRightJacobianInverseTimesVector(phi, alpha2);
  const Matrix9x3 whitened = Whiten(w_angular_, d_phi);
  const Eigen::Matrix3d w_f = w_linear_ * f_linear_, eye = Eigen::Matrix3d::Identity();
  if (jacobians[0] != nullptr) {
    Matrix18x6 d = Matrix18x6::Zero();
    d.block<9, 3>(kAngularRow, 0).noalias() = whitened * -jr_inverse.transpose();  // -Jl^-1(phi)
    for (int i = 0; i < 3; ++i) d.block<3, 3>(kLinearRow + 3 * i, 3) = -w_f(i, 0) * eye;
    LiftPoseJacobian(d, parameters[0], jacobians[0]);
  }
  if (jacobians[2] != nullptr) {
    Matrix18x6 d = Matrix18x6::Zero();
    d.block<9, 3>(kAngularRow, 0).noalias() = whitened * jr_inverse;
    for (int i = 0; i < 3; ++i) d.block<3, 3>(kLinearRow + 3 * i, 3) = w_linear_(i, 0) * eye;
    LiftPoseJacobian(d, parameters[2], jacobians[2]);
  }
}

void MotionResidual::DifferentiateByRates(const Eigen::Matrix3d& jr_inverse,
                                          double** jacobians) const {
  if (jacobians[1] != nullptr) {
    Matrix18x12 d = Matrix18x12::Zero();
    const Eigen::Matrix3d linear_by = -w_linear_ * f_linear_, angular_by = -w_angular_ * f_angular_;
    AddScaledColumn(linear_by, 1, kLinearRow, kV, &d);
    AddScaledColumn(linear_by, 2, kLinearRow, kA, &d);
    AddScaledColumn(angular_by, 1, kAngularRow, kOmega, &d);
    AddScaledColumn(angular_by, 2, kAngularRow, kAlpha, &d);
    Eigen::Map<Matrix18x12>{jacobians[1]} = d;
  }
  if (jacobians[3] != nullptr) {
    Matrix18x12 d = Matrix18x12::Zero();
    AddScaledColumn(w_linear_, 1, kLinearRow, kV, &d);
    AddScaledColumn(w_linear_, 2, kLinearRow, kA, &d);
    for (int i = 0; i < 3; ++i) {
      d.block<3, 3>(kAngularRow + 3 * i, kOmega) = w_angular_(i, 1) * jr_inverse;
      d.block<3, 3>(kAngularRow + 3 * i, kAlpha) = w_angular_(i, 2) * jr_inverse;
    }
    Eigen::Map<Matrix18x12>{jacobians[3]} = d;
  }
}

}  // namespace tagtwist
