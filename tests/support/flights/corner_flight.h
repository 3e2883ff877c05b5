#pragma once
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>

#include "frontend/pattern/corner_refiner.h"
#include "frontend/simulation/named_flights.h"
#include "frontend/simulation/simulator.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal {

// Rendered flights over the mat of the course for tests of the corner refiner.

using Corners = std::array<Eigen::Vector2d, 4>;

struct Setting {
  double noise_grey = 3, blur_px = 0.5, exposure_s = 0, vignetting = 0.2;
  std::string flight = "figure8";
  Camera camera = {};
  double height_m = 1.5;
  int jpeg_quality = 0;  // 0: none
};

struct Flight {
  SplineTrajectory trajectory;
  Simulator simulator;
};

inline Flight MakeFlightOf(const Setting& setting) {
  const TagMap map = MakeTagMap(TagGrid());
  FlightOptions flight;
  flight.height_m = setting.height_m;
  const auto trajectory = FlightPath(setting.flight, map, flight);
  SimulatorOptions options;
  options.random_seed = 77;
  options.corner_noise_px = 0;
  options.exposure_s = setting.exposure_s;
  options.renderer.noise_grey = setting.noise_grey;
  options.renderer.blur_px = setting.blur_px;
  options.renderer.vignetting = setting.vignetting;
  auto simulator =
      Simulator::Make(MakeSetUp(setting.camera, CourseCamFromBody(), map), *trajectory, options);
  EXPECT_TRUE(simulator);
  return {*trajectory, std::move(*simulator)};
}

inline SimulatedFrame MakeFrame(const Flight& flight, double share) {
  const auto length =
      static_cast<double>(flight.trajectory.last_ns() - flight.trajectory.first_ns());
  const auto t_ns = flight.trajectory.first_ns() + static_cast<int64_t>(share * length);
  return flight.simulator.MakeFrame(static_cast<uint64_t>(1000 * share), t_ns);
}

inline Eigen::Matrix<double, 8, 1> Difference(const Corners& a, const Corners& b) {
  Eigen::Matrix<double, 8, 1> out;
  for (int c = 0; c < 4; ++c) {
    out.segment<2>(2 * c) = a[static_cast<size_t>(c)] - b[static_cast<size_t>(c)];
  }
  return out;
}

inline CornerRefiner MakeRefiner(const Camera& camera = {}) {
  auto refiner = CornerRefiner::Create(MakeTagMap(TagGrid()), camera);
  EXPECT_TRUE(refiner);
  return std::move(*refiner);
}

}  // namespace tagtwist::internal
