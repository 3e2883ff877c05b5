#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// What an IMU's flight has besides SimulatedFlight's.
struct ImuFlightOptions {
  double duration_s = 12, rate_hz = 30;
  double gyro_noise_radps = 0.01, accel_noise_mps2 = 0.1;  // of a sample, at 200 Hz
  double clock_s = 0;                                      // the IMU's, ahead of the frames'
  double gap_period_s = 0, gap_s = 0;  // the last gap_s of every period have no tags
  uint64_t seed = 1;
};

/// A named flight over the course's mat with an IMU whose axes have biases of about 0.02 rad/s and
/// 0.2 m/s^2.
struct ImuFlight {
  std::vector<FrameMeasurements> measurements;
  std::vector<BodyState> truth;
  std::vector<ImuSample> imu;
};

ImuFlight SimulateWithImu(const std::string& name, const ImuFlightOptions& options);

}  // namespace tagtwist::internal
