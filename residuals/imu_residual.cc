#include "residuals/imu_residual.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

#include "frontend/types/so3.h"
#include "residuals/pose_manifold.h"

namespace tagtwist::internal {
namespace {

// The three-vectors in a block of rates.
constexpr int kOfV = 0, kOfOmega = 3, kOfAccelBias = 6, kOfGyroBias = 9;
// The residual's.
constexpr int kTurn = 0, kVelocity = 3, kPosition = 6, kGyroWalk = 9, kAccelWalk = 12;

Eigen::Matrix<double, 9, 9> RootOf(const Eigen::Matrix<double, 9, 9>& covariance) {
  const Eigen::LLT<Eigen::Matrix<double, 9, 9>> cholesky(covariance);
  return cholesky.matrixL().solve(Eigen::Matrix<double, 9, 9>::Identity());
}

void Lift(const Eigen::Matrix<double, 15, 6>& by_tangent, const double* pose, double* out) {
  Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift;
  PoseManifold().MinusJacobian(pose, lift.data());
  Eigen::Map<Eigen::Matrix<double, 15, 7, Eigen::RowMajor>>(out).noalias() = by_tangent * lift;
}

}  // namespace

ImuResidual::ImuResidual(const Preintegration& motion, const Eigen::Vector3d& imu_in_body_m,
                         const Eigen::Vector3d& gravity_world_mps2, double gyro_walk_radps,
                         double accel_walk_mps2)
    : motion_(motion),
      place_(imu_in_body_m),
      gravity_(gravity_world_mps2),
      root_(RootOf(motion.covariance)),
      gyro_root_(1 / gyro_walk_radps),
      accel_root_(1 / accel_walk_mps2) {}

double ImuResidual::LogDetInformation() const {
  return 2 * root_.diagonal().array().log().sum() +
         6 * (std::log(gyro_root_) + std::log(accel_root_));
}

Eigen::Matrix<double, 15, 3> ImuResidual::ByPlace(double const* const* parameters) const {
  using Vector3Map = Eigen::Map<const Eigen::Vector3d>;
  const Eigen::Map<const Eigen::Quaterniond> q1(parameters[0]), q2(parameters[2]);
  const Eigen::Matrix3d rotation = (q1.conjugate() * q2).toRotationMatrix();
  const Eigen::Matrix3d turns1 = Hat(Vector3Map(parameters[1] + kOfOmega)),
                        turns2 = Hat(Vector3Map(parameters[3] + kOfOmega));
  Eigen::Matrix<double, 9, 3> by = Eigen::Matrix<double, 9, 3>::Zero();
  by.middleRows<3>(kVelocity) = rotation * turns2 - turns1;
  by.middleRows<3>(kPosition) = rotation - Eigen::Matrix3d::Identity() - motion_.dt_s * turns1;
  Eigen::Matrix<double, 15, 3> out = Eigen::Matrix<double, 15, 3>::Zero();
  out.topRows<9>() = root_ * by;
  return out;
}

Eigen::Matrix<double, 15, 3> ImuResidual::ByGravity(double const* const* parameters) const {
  const Eigen::Map<const Eigen::Quaterniond> q1(parameters[0]);
  const Eigen::Matrix3d to_first = q1.conjugate().toRotationMatrix();
  Eigen::Matrix<double, 9, 3> by = Eigen::Matrix<double, 9, 3>::Zero();
  by.middleRows<3>(kVelocity) = -motion_.dt_s * to_first;
  by.middleRows<3>(kPosition) = -0.5 * motion_.dt_s * motion_.dt_s * to_first;
  Eigen::Matrix<double, 15, 3> out = Eigen::Matrix<double, 15, 3>::Zero();
  out.topRows<9>() = root_ * by;
  return out;
}

// What is measured turns as a whole: dR becomes Exp(t) dR Exp(-t), dv Exp(t) dv, and dp likewise.
Eigen::Matrix<double, 15, 3> ImuResidual::ByAxes() const {
  Eigen::Matrix<double, 9, 3> by;
  by.middleRows<3>(kTurn) =
      Eigen::Matrix3d::Identity() - motion_.rotation.conjugate().toRotationMatrix();
  by.middleRows<3>(kVelocity) = Hat(motion_.velocity_mps);
  by.middleRows<3>(kPosition) = Hat(motion_.position_m);
  Eigen::Matrix<double, 15, 3> out = Eigen::Matrix<double, 15, 3>::Zero();
  out.topRows<9>() = root_ * by;
  return out;
}

// Of two states as they are: what the residual and its derivatives are made of.
struct ImuResidual::Terms {
  Eigen::Matrix<double, 9, 1> by_bias;         // what the first bias adds to the motion
  Eigen::Matrix3d to_first, second_to_first;   // rotations: R_1', R_2' R_1
  Eigen::Vector3d round1, round2;              // omega x l, in body 1 and in body 2
  Eigen::Vector3d turn;                        // r_theta
  Eigen::Vector3d velocity, position;          // of the states, in body 1, as seen from W,
  Eigen::Vector3d own_velocity, own_position;  // less what is of body 1 itself
  Eigen::Matrix3d jr_inverse;                  // of the turn
};

ImuResidual::Terms ImuResidual::TermsOf(double const* const* parameters) const {
  using Vector3Map = Eigen::Map<const Eigen::Vector3d>;
  const Eigen::Map<const Eigen::Quaterniond> q1(parameters[0]), q2(parameters[2]);
  const Vector3Map p1(parameters[0] + 4), p2(parameters[2] + 4);
  const Vector3Map v1(parameters[1] + kOfV), v2(parameters[3] + kOfV);
  const Vector3Map omega1(parameters[1] + kOfOmega), omega2(parameters[3] + kOfOmega);
  const double dt_s = motion_.dt_s;
  Eigen::Matrix<double, 6, 1> bias;
  bias << Vector3Map(parameters[1] + kOfGyroBias) - motion_.bias.gyro_radps,
      Vector3Map(parameters[1] + kOfAccelBias) - motion_.bias.accel_mps2;
  Terms out;
  out.by_bias = motion_.by_bias * bias;
  out.to_first = q1.toRotationMatrix().transpose();
  out.second_to_first = (q2.conjugate() * q1).toRotationMatrix();
  out.turn = LogSo3((motion_.rotation * ExpSo3(out.by_bias.head<3>())).conjugate() *
                    (q1.conjugate() * q2));
  out.round1 = omega1.cross(place_);
  out.round2 = omega2.cross(place_);
  const Eigen::Matrix3d first_from_second = out.second_to_first.transpose();
  out.velocity = out.to_first * (v2 - v1 - dt_s * gravity_) + first_from_second * out.round2;
  out.position = out.to_first * (p2 - p1 - dt_s * v1 - 0.5 * dt_s * dt_s * gravity_) +
                 first_from_second * place_;
  out.own_velocity = out.velocity - out.round1;
  out.own_position = out.position - place_ - dt_s * out.round1;
  out.jr_inverse = RightJacobianInverseSo3(out.turn);
  return out;
}

// By the first state: pose, then rates.
void ImuResidual::DifferentiateByFirst(const Terms& terms, Matrix15x6* pose,
                                       Matrix15x12* rates) const {
  pose->setZero();
  pose->block<3, 3>(kTurn, 0) = -terms.jr_inverse * terms.second_to_first;
  pose->block<3, 3>(kVelocity, 0) = Hat(terms.velocity);
  pose->block<3, 3>(kPosition, 0) = Hat(terms.position);
  pose->block<3, 3>(kPosition, 3) = -terms.to_first;
  rates->setZero();
  rates->block<3, 3>(kVelocity, kOfV) = -terms.to_first;
  rates->block<3, 3>(kPosition, kOfV) = -motion_.dt_s * terms.to_first;
  rates->block<3, 3>(kVelocity, kOfOmega) = Hat(place_);
  rates->block<3, 3>(kPosition, kOfOmega) = motion_.dt_s * Hat(place_);
  rates->block<3, 3>(kTurn, kOfGyroBias) =
      -terms.jr_inverse * ExpSo3(terms.turn).toRotationMatrix().transpose() *
      RightJacobianSo3(terms.by_bias.head<3>()) * motion_.by_bias.topLeftCorner<3, 3>();
  rates->block<6, 3>(kVelocity, kOfGyroBias) = -motion_.by_bias.bottomLeftCorner<6, 3>();
  rates->block<6, 3>(kVelocity, kOfAccelBias) = -motion_.by_bias.bottomRightCorner<6, 3>();
  rates->block<3, 3>(kGyroWalk, kOfGyroBias).diagonal().setConstant(-gyro_root_);
  rates->block<3, 3>(kAccelWalk, kOfAccelBias).diagonal().setConstant(-accel_root_);
  pose->topRows<9>() = (root_ * pose->topRows<9>()).eval();
  rates->topRows<9>() = (root_ * rates->topRows<9>()).eval();
}

// By the second one.
void ImuResidual::DifferentiateBySecond(const Terms& terms, Matrix15x6* pose,
                                        Matrix15x12* rates) const {
  pose->setZero();
  const Eigen::Matrix3d first_from_second = terms.second_to_first.transpose();
  pose->block<3, 3>(kTurn, 0) = terms.jr_inverse;
  pose->block<3, 3>(kVelocity, 0) = -first_from_second * Hat(terms.round2);
  pose->block<3, 3>(kPosition, 0) = -first_from_second * Hat(place_);
  pose->block<3, 3>(kPosition, 3) = terms.to_first;
  rates->setZero();
  rates->block<3, 3>(kVelocity, kOfV) = terms.to_first;
  rates->block<3, 3>(kVelocity, kOfOmega) = -first_from_second * Hat(place_);
  rates->block<3, 3>(kGyroWalk, kOfGyroBias).diagonal().setConstant(gyro_root_);
  rates->block<3, 3>(kAccelWalk, kOfAccelBias).diagonal().setConstant(accel_root_);
  pose->topRows<9>() = (root_ * pose->topRows<9>()).eval();
  rates->topRows<9>() = (root_ * rates->topRows<9>()).eval();
}

bool ImuResidual::Evaluate(double const* const* parameters, double* residuals,
                           double** jacobians) const {
  using Vector3Map = Eigen::Map<const Eigen::Vector3d>;
  const Terms terms = TermsOf(parameters);
  Eigen::Matrix<double, 9, 1> motion;
  motion << terms.turn, terms.own_velocity - motion_.velocity_mps - terms.by_bias.segment<3>(3),
      terms.own_position - motion_.position_m - terms.by_bias.tail<3>();
  Eigen::Map<Eigen::Matrix<double, 15, 1>> r(residuals);
  r.head<9>() = root_ * motion;
  r.segment<3>(kGyroWalk) = gyro_root_ * (Vector3Map(parameters[3] + kOfGyroBias) -
                                          Vector3Map(parameters[1] + kOfGyroBias));
  r.segment<3>(kAccelWalk) = accel_root_ * (Vector3Map(parameters[3] + kOfAccelBias) -
                                            Vector3Map(parameters[1] + kOfAccelBias));
  if (jacobians == nullptr) return true;
  using OfRates = Eigen::Map<Eigen::Matrix<double, 15, 12, Eigen::RowMajor>>;
  Matrix15x6 pose;
  Matrix15x12 rates;
  for (int state = 0; state < 2; ++state) {
    if (state == 0) {
      DifferentiateByFirst(terms, &pose, &rates);
    } else {
      DifferentiateBySecond(terms, &pose, &rates);
    }
    if (jacobians[2 * state] != nullptr) {
      Lift(pose, parameters[2 * state], jacobians[2 * state]);
    }
    if (jacobians[2 * state + 1] != nullptr) OfRates{jacobians[2 * state + 1]} = rates;
  }
  return true;
}

bool GyroRateResidual::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  using Vector3Map = Eigen::Map<const Eigen::Vector3d>;
  const Vector3Map omega(parameters[0] + kOfOmega), bias(parameters[0] + kOfGyroBias);
  Eigen::Map<Eigen::Vector3d>{residuals} = root_ * (omega + bias - measured_);
  if (jacobians == nullptr || jacobians[0] == nullptr) return true;
  Eigen::Map<Eigen::Matrix<double, 3, 12, Eigen::RowMajor>> by(jacobians[0]);
  by.setZero();
  by.middleCols<3>(kOfOmega).diagonal().setConstant(root_);
  by.middleCols<3>(kOfGyroBias).diagonal().setConstant(root_);
  return true;
}

bool BiasWalkResidual::Evaluate(double const* const* parameters, double* residuals,
                                double** jacobians) const {
  using Vector3Map = Eigen::Map<const Eigen::Vector3d>;
  Eigen::Map<Eigen::Vector3d>{residuals} = gyro_root_ * (Vector3Map(parameters[1] + kOfGyroBias) -
                                                         Vector3Map(parameters[0] + kOfGyroBias));
  Eigen::Map<Eigen::Vector3d>{residuals + 3} =
      accel_root_ *
      (Vector3Map(parameters[1] + kOfAccelBias) - Vector3Map(parameters[0] + kOfAccelBias));
  if (jacobians == nullptr) return true;
  for (int i = 0; i < 2; ++i) {
    if (jacobians[i] == nullptr) continue;
    Eigen::Map<Eigen::Matrix<double, 6, 12, Eigen::RowMajor>> by(jacobians[i]);
    by.setZero();
    by.block<3, 3>(0, kOfGyroBias).diagonal().setConstant(i == 0 ? -gyro_root_ : gyro_root_);
    by.block<3, 3>(3, kOfAccelBias).diagonal().setConstant(i == 0 ? -accel_root_ : accel_root_);
  }
  return true;
}

double BiasWalkResidual::LogDetInformation() const {
  return 6 * (std::log(gyro_root_) + std::log(accel_root_));
}

}  // namespace tagtwist::internal
