#include "estimator/imu/imu_options.h"

#include "frontend/base/option_check.h"

namespace tagtwist {

std::optional<std::string> ImuOptions::Problem() const {
  const auto density = [](const char* name, double value) {
    return internal::CheckRange(name, value, 1e-9, 1e3);
  };
  if (auto p = density("gyroscope_noise_density", gyroscope_noise_density)) return p;
  if (auto p = density("accelerometer_noise_density", accelerometer_noise_density)) return p;
  if (auto p = density("gyroscope_random_walk", gyroscope_random_walk)) return p;
  if (auto p = density("accelerometer_random_walk", accelerometer_random_walk)) return p;
  if (auto p = internal::CheckRange("gravity_mps2", gravity_mps2, 0.1, 100)) return p;
  if (auto p = internal::CheckRange("time_offset_s", time_offset_s, -1e6, 1e6)) return p;
  if (auto p = internal::CheckRange("time_offset_sigma_s", time_offset_sigma_s, 0, 1)) return p;
  if (auto p = internal::CheckRange("mount_sigma_rad", mount_sigma_rad, 0, 1)) return p;
  if (auto p = internal::CheckRange("mount_sigma_m", mount_sigma_m, 0, 1)) return p;
  constexpr double kMostM = 100;
  const double away_m = body_from_imu.translation().norm();
  return internal::CheckRange("body_from_imu: its distance", away_m, 0, kMostM);
}

}  // namespace tagtwist
