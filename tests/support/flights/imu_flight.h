#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "estimator/result/estimate.h"
#include "frontend/types/body_state.h"
#include "tests/support/flights/simulated_flight.h"

namespace tagtwist::internal {

/// What an IMU's flight has besides SimulatedFlight's.
struct ImuFlightOptions {
  double duration_s = 12, rate_hz = 30;
  double gyro_noise_radps = 0.01, accel_noise_mps2 = 0.1;  // of a sample, at 200 Hz
  double corner_noise_px = 0.15;
  double clock_s = 0;                  // the IMU's, ahead of the frames'
  double gap_period_s = 0, gap_s = 0;  // the last gap_s of every period have no tags
  uint64_t seed = 1;
};

/// A named flight over the course's mat with an IMU whose axes have biases of about 0.02 rad/s and
/// 0.2 m/s^2.
struct ImuFlight : SimulatedFlight {
  std::vector<ImuSample> imu;
};

ImuFlight SimulateWithImu(const std::string& name, const ImuFlightOptions& options);

/// Of frames, each with a state, from a time on, with tags or without. NEES per degree of freedom.
struct ImuFlightErrors {
  double position_m = 0, velocity_mps = 0, rate_radps = 0, largest_m = 0, nees_pose = 0,
         nees_twist = 0;
  int n = 0;
};
ImuFlightErrors ErrorsOf(const std::vector<FrameEstimate>& frames, const ImuFlight& flight,
                         bool with_tags, double from_s = 0);

}  // namespace tagtwist::internal
