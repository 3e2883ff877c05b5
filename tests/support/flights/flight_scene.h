#pragma once
#include <gtest/gtest.h>

#include "frontend/simulation/named_flights.h"
#include "frontend/simulation/simulator.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal {

/// A simulated flight over a map with the course's camera and mount.
struct RenderedFlight {
  SplineTrajectory trajectory;
  Simulator simulator;

  int64_t StampAt(double t_s) const {
    return trajectory.first_ns() + static_cast<int64_t>(1e9 * t_s);
  }
};

inline RenderedFlight MakeRenderedFlight(const std::string& name, const TagMap& map,
                                         const SimulatorOptions& options) {
  const auto trajectory = FlightPath(name, map, {});
  EXPECT_TRUE(trajectory);
  auto simulator = Simulator::Make(MakeSetUp({}, CourseCamFromBody(), map), *trajectory, options);
  EXPECT_TRUE(simulator);
  return {*trajectory, std::move(*simulator)};
}

}  // namespace tagtwist::internal
