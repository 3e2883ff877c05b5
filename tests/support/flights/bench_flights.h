#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "estimator/online/config.h"
#include "frontend/base/result.h"
#include "frontend/simulation/simulator.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// One row of the grid: a named flight over the course's mat, and what is hard about it.
struct BenchFlight {
  std::string name;                    // in the table
  std::string trajectory = "figure8";  // of FlightNames()
  double jitter_s = 0.002;             // of the stamps, either way
  bool one_tag = false;  // of each frame only the tag nearest to the image's centre is kept
  SimulatorOptions simulator;
};

/// Gentle, agile, one tag, 70 % of the tags hidden, jitter: corners with Gaussian noise of
/// corner_noise_px; blur: from rendered images (10 ms of exposure, 0.8 px of defocus, noise of 3
/// grey levels).
std::vector<BenchFlight> BenchGrid(double corner_noise_px);

/// A flight as the estimators take it.
struct BenchRun {
  std::vector<FrameMeasurements> measurements;
  std::vector<TruthSample> truth;  // one a frame
};

/// Simulates and measures the flight. The seed picks the noise, the stamps and the height, 1.0 to
/// 1.4 m; the same arguments give the same run.
Result<BenchRun> MakeBenchRun(const BenchFlight& flight, const Config& config, double duration_s,
                              uint64_t seed);

}  // namespace tagtwist::internal
