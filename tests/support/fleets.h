#pragma once
#include <cmath>
#include <string>

#include "estimator/fleet/figures.h"
#include "estimator/fleet/fleet_row.h"
#include "frontend/base/statistics/random_stream.h"

namespace tagtwist::internal {

/// A fleet of `recordings` flights, each estimated from a draw of noise: figures differ from flight
/// to flight, and errors from draw to draw. `noise`: of the corners, 1 as usual.
inline Fleet DrawFleet(size_t recordings, double noise, uint64_t seed) {
  Fleet out{"fleet " + std::to_string(seed), {}};
  for (size_t i = 0; i < recordings; ++i) {
    RandomStream flight(1, i), draw(seed, i);
    FleetRow row;
    row.name = "flight " + std::to_string(i);
    row.folder = "runs/flight-" + std::to_string(i);
    row.version = "0.1.0";
    row.verdict = "To be relied on within its sigmas: nothing speaks against it.";
    row.frames = row.frames_estimated = 100 + 10 * static_cast<double>(i);
    for (const Figure& figure : Figures()) {
      const std::string key = figure.key;
      const bool is_sigma = key.rfind("bound", 0) == 0 || key.find("_px") != std::string::npos;
      const bool is_noisy =
          figure.worse == Figure::Worse::kLarger && key.find("over") == std::string::npos;
      const double own = is_noisy ? std::exp(-6 + 0.5 * flight.Normal()) : 1;
      row.figures.push_back(own * (is_noisy ? noise : 1) *
                            std::exp((is_sigma ? 0.01 : 0.15) * draw.Normal()));
    }
    out.rows.push_back(row);
  }
  return out;
}

}  // namespace tagtwist::internal
