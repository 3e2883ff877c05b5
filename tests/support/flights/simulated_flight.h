#pragma once
#include <string>
#include <vector>

#include "frontend/simulation/simulator.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// A named flight over the course's mat, 1.2 m up: corners with noise of 0.15 px, steady stamps.
struct SimulatedFlight {
  std::vector<FrameMeasurements> measurements;
  std::vector<BodyState> truth;
};

/// A simulator's frames over its whole trajectory, by a steady clock.
SimulatedFlight RecordFrames(const Simulator& simulator, double rate_hz);

SimulatedFlight SimulateCorners(const std::string& name, double duration_s, double rate_hz = 49);

}  // namespace tagtwist::internal
