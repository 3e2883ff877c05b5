#pragma once
#include <cstdint>
#include <string>

#include "estimator/online/config.h"
#include "frontend/base/result.h"
#include "frontend/simulation/simulator.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// A named flight flown forth and back for ever, corners alone: frames are made as they are asked
/// for, none is kept. Named flights begin and end at rest, so that the turns are smooth.
class EndlessFlight {
 public:
  static Result<EndlessFlight> Make(const Config& config, const std::string& name, double rate_hz,
                                    double corner_noise_px, uint64_t seed);
  /// Frame `index`, counted from 0: what is seen, and the truth.
  SimulatedFrame At(int64_t index) const;

 private:
  EndlessFlight(Simulator simulator, double rate_hz)
      : simulator_(std::move(simulator)), rate_hz_(rate_hz) {}

  Simulator simulator_;
  double rate_hz_;
};

}  // namespace tagtwist::internal
