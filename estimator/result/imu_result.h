#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tagtwist {

/// What a recording told of its IMU.
struct ImuResult {
  Eigen::Vector3d gravity_world_mps2 = Eigen::Vector3d::Zero();
  double gravity_sigma_rad = 0;  // of its direction, the wider axis
  double time_offset_s = 0;      // the IMU's clock less that of the frames' stamps
  double time_offset_sigma_s = 0;
  Eigen::Vector3d mount_rad = Eigen::Vector3d::Zero();  // turn of body_from_imu, from as it is told
  Eigen::Vector3d mount_sigma_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d imu_in_body_m = Eigen::Vector3d::Zero();  // where it is
  Eigen::Vector3d imu_in_body_sigma_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero(),  // at the middle of the recording
      gyro_bias_sigma_radps = Eigen::Vector3d::Zero(), accel_bias_mps2 = Eigen::Vector3d::Zero(),
                  accel_bias_sigma_mps2 = Eigen::Vector3d::Zero();
  double gyro_noise = 0, accel_noise = 0;  // densities [rad/s/sqrt(Hz)], [m/s^2/sqrt(Hz)]
  int intervals = 0;                       // between frames, that it covers
};

}  // namespace tagtwist
