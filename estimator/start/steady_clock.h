#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// A camera's clock that ticks steadily, where the stamps were taken late and unevenly.
struct SteadyClock {
  std::vector<int64_t> t_ns;    // one a stamp, strictly growing
  double period_s = 0;          // between frames
  double rms_s = 0;             // of stamps - t
  bool is_evident = false;      // most stamps are at the ticks, to a fiftieth of a period
  std::vector<double> sigma_s;  // of each t, standard deviation: the line through the stamps
};

/// Least squares of stamp_i = first + period * n_i over the first time and the period. The frame
/// numbers n_i grow by 1, or, now and then, by more where frames seem lost, whichever fits better.
/// Stamps that were taken late now and then, most being in time, do not count. nullopt for fewer
/// than ten stamps, and where one of the others lies 0.75 periods or more from its tick (of stamps
/// that come n > 2 at a time n - 1 times that): no steady clock.
std::optional<SteadyClock> FitSteadyClock(const std::vector<int64_t>& stamps_ns);

/// Covariance by the uncertainty of when a frame was taken, which moves a state along its motion.
/// Accelerations matter less and are left out.
StateCovariance OfClock(const BodyState& state, double sigma_s);

/// What a clock does with a recording, in a line.
std::string TextOf(const SteadyClock& clock);

}  // namespace tagtwist::internal
