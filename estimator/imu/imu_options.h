#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/types/body_state.h"
#include "frontend/types/pose.h"

namespace tagtwist {

/// An IMU on the body. Field names are the YAML keys of the section
/// `imu`; the first four are those of Kalibr's imu.yaml and of EuRoC's sensor.yaml.
struct ImuOptions {
  double gyroscope_noise_density = 2e-3;      // [rad/s/sqrt(Hz)], > 0
  double accelerometer_noise_density = 2e-2;  // [m/s^2/sqrt(Hz)], > 0
  double gyroscope_random_walk = 1e-4;        // of the bias [rad/s^2/sqrt(Hz)], > 0
  double accelerometer_random_walk = 3e-3;    // [m/s^3/sqrt(Hz)], > 0
  bool learn_noise = true;                    // densities are multiplied by what the recording says
  double gravity_mps2 = 9.81;                 // its direction is found, > 0
  double time_offset_s = 0;                   // the IMU's clock less that of the frames' stamps
  double time_offset_sigma_s = 0.01;          // >= 0; 0: as given, else it is refined
  Pose body_from_imu;             // where it is, and how its axes lie; not one of the fields below
  double mount_sigma_rad = 0.02;  // of each axis of the IMU against that, >= 0; likewise
  double mount_sigma_m = 0.01;    // of each coordinate of its place, >= 0; likewise

  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("gyroscope_noise_density", self.gyroscope_noise_density);
    visit("accelerometer_noise_density", self.accelerometer_noise_density);
    visit("gyroscope_random_walk", self.gyroscope_random_walk);
    visit("accelerometer_random_walk", self.accelerometer_random_walk);
    visit("learn_noise", self.learn_noise);
    visit("gravity_mps2", self.gravity_mps2);
    visit("time_offset_s", self.time_offset_s);
    visit("time_offset_sigma_s", self.time_offset_sigma_s);
    visit("mount_sigma_rad", self.mount_sigma_rad);
    visit("mount_sigma_m", self.mount_sigma_m);
  }
};

/// What it said over a recording; stamps grow strictly.
struct ImuRecord {
  ImuOptions options;
  std::vector<ImuSample> samples;
};

}  // namespace tagtwist
