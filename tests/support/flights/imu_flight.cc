#include "tests/support/flights/imu_flight.h"

#include <cmath>

#include "estimator/online/config.h"
#include "frontend/simulation/named_flights.h"
#include "frontend/simulation/simulator.h"

namespace tagtwist::internal {

ImuFlight SimulateWithImu(const std::string& name, const ImuFlightOptions& options) {
  const Config config = DefaultConfig();
  const auto trajectory = *FlightPath(name, config.set_up.map, {options.duration_s, 1.2});
  SimulatorOptions drawn;
  drawn.images = false;
  drawn.random_seed = options.seed;
  drawn.corner_noise_px = 0.15;
  drawn.gyro_noise_radps = options.gyro_noise_radps;
  drawn.accel_noise_mps2 = options.accel_noise_mps2;
  drawn.gyro_bias_radps = 0.02;
  drawn.accel_bias_mps2 = 0.2;
  const auto simulator = *Simulator::Make(config.set_up, trajectory, drawn);
  StampOptions stamps;
  stamps.rate_hz = options.rate_hz;
  const auto times = MakeStamps(trajectory.first_ns(), trajectory.last_ns(), stamps);
  ImuFlight out;
  out.imu = simulator.MakeImu(trajectory.first_ns(), trajectory.last_ns());
  for (ImuSample& sample : out.imu) sample.t_ns += std::llround(1e9 * options.clock_s);
  for (const int64_t t_ns : *times) {
    const SimulatedFrame frame = simulator.MakeFrame(out.truth.size(), t_ns);
    out.measurements.emplace_back();
    out.measurements.back().t_ns = t_ns;
    out.truth.push_back(frame.truth);
    const double into_s = options.gap_period_s > 0
                              ? std::fmod(ToSeconds(t_ns - times->front()), options.gap_period_s)
                              : 0;
    const bool is_hidden =
        options.gap_period_s > 0 && into_s >= options.gap_period_s - options.gap_s;
    if (!is_hidden) out.measurements.back().tags = frame.detections;
  }
  return out;
}

}  // namespace tagtwist::internal
