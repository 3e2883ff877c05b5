#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// What an IMU's two sensors say at rest, and without weight.
struct ImuBias {
  Eigen::Vector3d gyro_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_mps2 = Eigen::Vector3d::Zero();
};

/// White noise of an IMU, as data sheets have it.
struct ImuNoise {
  double gyro = 2e-3;   // [rad/s/sqrt(Hz)], > 0
  double accel = 2e-2;  // [m/s^2/sqrt(Hz)], > 0
};

/// The motion that IMU samples say between two times, whatever the body's state at the first:
/// rotation body_1_from_body_2, and velocity and position gained in body 1, but for gravity and for
/// what the first velocity does. Errors [theta(3) of the rotation on its right; velocity(3);
/// position(3)] (Forster, Carlone, Dellaert and Scaramuzza 2017, section VI).
struct Preintegration {
  double dt_s = 0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero(), position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();
  /// Derivative of those errors by [gyro(3); accel(3)] bias, at `bias`.
  Eigen::Matrix<double, 9, 6> by_bias = Eigen::Matrix<double, 9, 6>::Zero();
  ImuBias bias;  // that it was made with
};

/// The samples around a time, linear between them: nullopt before the first, after the last, and
/// where two neighbours are more than `longest_step_s` apart. Stamps must grow.
std::optional<ImuSample> ImuAt(const std::vector<ImuSample>& samples, int64_t t_ns,
                               double longest_step_s);

/// Over [from_ns, to_ns], by the midpoints of the steps between samples; nullopt where they do not
/// cover it (as ImuAt).
std::optional<Preintegration> Preintegrate(const std::vector<ImuSample>& samples, int64_t from_ns,
                                           int64_t to_ns, const ImuBias& bias,
                                           const ImuNoise& noise, double longest_step_s);

}  // namespace tagtwist::internal
