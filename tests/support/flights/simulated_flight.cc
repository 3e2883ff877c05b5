#include "tests/support/flights/simulated_flight.h"

#include "estimator/online/config.h"
#include "frontend/simulation/named_flights.h"
#include "frontend/simulation/simulator.h"

namespace tagtwist::internal {

SimulatedFlight RecordFrames(const Simulator& simulator, double rate_hz) {
  const SplineTrajectory& trajectory = simulator.trajectory();
  StampOptions stamps;
  stamps.rate_hz = rate_hz;
  stamps.jitter_s = 0;
  const auto times = MakeStamps(trajectory.first_ns(), trajectory.last_ns(), stamps);
  SimulatedFlight out;
  for (const int64_t t_ns : *times) {
    const SimulatedFrame frame = simulator.MakeFrame(out.truth.size(), t_ns);
    out.measurements.emplace_back();
    out.measurements.back().t_ns = t_ns;
    out.measurements.back().tags = frame.detections;
    out.truth.push_back(frame.truth);
  }
  return out;
}

SimulatedFlight SimulateCorners(const std::string& name, double duration_s, double rate_hz) {
  const Config config = DefaultConfig();
  SimulatorOptions options;
  options.images = false;
  options.corner_noise_px = 0.15;
  const auto trajectory = *FlightPath(name, config.set_up.map, {duration_s, 1.2});
  return RecordFrames(*Simulator::Make(config.set_up, trajectory, options), rate_hz);
}

}  // namespace tagtwist::internal
