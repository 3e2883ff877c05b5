#include "bench/endless_flight.h"

#include <cmath>
#include <utility>

#include "frontend/simulation/named_flights.h"

namespace tagtwist::internal {

Result<EndlessFlight> EndlessFlight::Make(const Config& config, const std::string& name,
                                          double rate_hz, double corner_noise_px, uint64_t seed) {
  FlightOptions flight;
  flight.duration_s = 60;
  const auto path = FlightPath(name, config.set_up.map, flight);
  if (!path) return path.error();
  SimulatorOptions options;
  options.images = false;
  options.corner_noise_px = corner_noise_px;
  options.random_seed = seed;
  auto simulator = Simulator::Make(config.set_up, *path, options);
  if (!simulator) return simulator.error();
  return EndlessFlight(std::move(*simulator), rate_hz);
}

SimulatedFrame EndlessFlight::At(int64_t index) const {
  const SplineTrajectory& path = simulator_.trajectory();
  const int64_t length_ns = path.last_ns() - path.first_ns();
  const auto t_ns = static_cast<int64_t>(std::llround(1e9 * static_cast<double>(index) / rate_hz_));
  const int64_t phase_ns = t_ns % (2 * length_ns);
  const bool is_back = phase_ns > length_ns;
  SimulatedFrame frame =
      simulator_.MakeFrame(static_cast<uint64_t>(index),
                           path.first_ns() + (is_back ? 2 * length_ns - phase_ns : phase_ns));
  frame.t_ns = t_ns;
  if (is_back) {
    frame.truth.twist.v_world *= -1;
    frame.truth.twist.omega_body *= -1;
  }
  return frame;
}

}  // namespace tagtwist::internal
