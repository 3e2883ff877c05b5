#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// A camera's attitude at a stamp.
struct TimedRotation {
  int64_t t_ns = 0;
  Eigen::Quaterniond world_from_cam;
};

/// A gyro that moves with the camera: rate_in_cam(stamp) = cam_from_imu * (gyro(stamp + offset) -
/// bias).
struct GyroAlignment {
  Eigen::Quaterniond cam_from_imu = Eigen::Quaterniond::Identity();
  Eigen::Vector3d bias_radps = Eigen::Vector3d::Zero();
  double time_offset_s = 0;
  /// Covariance of [turn of cam_from_imu on its right (rad), bias, offset].
  Eigen::Matrix<double, 7, 7> covariance = Eigen::Matrix<double, 7, 7>::Zero();
  double turn_sigma_rad = 0;    // misfit of a turn between two frames, an axis
  double turn_correlation = 0;  // of successive ones: they share a frame
  int turns = 0;
};

/// From the turns between successive frames, against the gyro integrated over the same time:
///   least sum rho(|Log(Exp(cam_from_imu (g_i - bias dt))' C_i' C_i+1)|^2),
/// g_i the gyro's rotation vector from t_i to t_i+1, both + offset; rho Huber's loss, misfits
/// whitened by their correlation. Starts from the best offset within `max_offset_s`, every 10 ms.
/// An error when there are fewer than 20 turns, or they are about fewer than two axes.
Result<GyroAlignment> AlignGyro(const std::vector<TimedRotation>& camera,
                                const std::vector<ImuSample>& imu, double max_offset_s = 0.2);

/// In words, one line.
std::string GyroText(const GyroAlignment& alignment);

}  // namespace tagtwist::internal
