#include "tests/support/flights/imu_flight.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/online/config.h"
#include "frontend/simulation/named_flights.h"
#include "frontend/simulation/simulator.h"
#include "frontend/types/nees.h"

namespace tagtwist::internal {

ImuFlight SimulateWithImu(const std::string& name, const ImuFlightOptions& options) {
  const Config config = DefaultConfig();
  const auto trajectory = *FlightPath(name, config.set_up.map, {options.duration_s, 1.2});
  SimulatorOptions drawn;
  drawn.images = false;
  drawn.random_seed = options.seed;
  drawn.corner_noise_px = options.corner_noise_px;
  drawn.gyro_noise_radps = options.gyro_noise_radps;
  drawn.accel_noise_mps2 = options.accel_noise_mps2;
  drawn.gyro_bias_radps = 0.02;
  drawn.accel_bias_mps2 = 0.2;
  const auto simulator = *Simulator::Make(config.set_up, trajectory, drawn);
  ImuFlight out{RecordFrames(simulator, options.rate_hz),
                simulator.MakeImu(trajectory.first_ns(), trajectory.last_ns())};
  for (ImuSample& sample : out.imu) sample.t_ns += std::llround(1e9 * options.clock_s);
  if (options.gap_period_s <= 0) return out;
  for (FrameMeasurements& frame : out.measurements) {
    const double into_s =
        std::fmod(ToSeconds(frame.t_ns - out.measurements[0].t_ns), options.gap_period_s);
    if (into_s >= options.gap_period_s - options.gap_s) frame.tags.clear();
  }
  return out;
}

ImuFlightErrors ErrorsOf(const std::vector<FrameEstimate>& frames, const ImuFlight& flight,
                         bool with_tags, double from_s) {
  ImuFlightErrors out;
  for (size_t i = 0; i < frames.size(); ++i) {
    const FrameEstimate& frame = frames[i];
    EXPECT_EQ(frame.t_ns, flight.measurements[i].t_ns);
    if (flight.measurements[i].tags.empty() == with_tags) continue;
    if (ToSeconds(frame.t_ns - frames[0].t_ns) < from_s) continue;
    EXPECT_EQ(frame.status, with_tags ? FrameStatus::kOk : FrameStatus::kPredicted) << i;
    const StateVector d = Difference(frame.state, flight.truth[i]);
    const auto nees = [&](const std::array<int, 2>& entries) {
      return Nees(flight.truth[i], frame.state, frame.covariance, entries).value_or(1e9) / 6;
    };
    out.nees_pose += nees(kPoseEntries);
    out.nees_twist += nees(kTwistEntries);
    out.largest_m = std::max(out.largest_m, d.segment<3>(3).norm());
    out.position_m += d.segment<3>(3).squaredNorm();
    out.velocity_mps += d.segment<3>(6).squaredNorm();
    out.rate_radps += d.tail<3>().squaredNorm();
    ++out.n;
  }
  out.position_m = std::sqrt(out.position_m / out.n);
  out.velocity_mps = std::sqrt(out.velocity_mps / out.n);
  out.rate_radps = std::sqrt(out.rate_radps / out.n);
  out.nees_pose /= out.n;
  out.nees_twist /= out.n;
  return out;
}

}  // namespace tagtwist::internal
