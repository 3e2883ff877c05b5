#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/estimate.h"
#include "frontend/types/body_state.h"

namespace tagtwist {

/// A state and its covariance (error state of BodyState).
struct StateAndCovariance {
  BodyState state;
  StateCovariance covariance = StateCovariance::Zero();
};

/// Smoothed states with what is needed to ask between them. The prior between neighbours is white
/// noise on acceleration, so that the trajectory is a Gaussian process: exact between the states,
/// covariance included (Barfoot, State Estimation for Robotics, ch. 11; Anderson and Barfoot 2015).
struct Trajectory {
  std::vector<int64_t> t_ns;  // strictly growing
  std::vector<BodyState> states;
  std::vector<StateCovariance> covariances;
  std::vector<StateCovariance> cross_covariances;  // [k]: of state k + 1 (rows) with state k
  double accel_psd = 0, angular_accel_psd = 0;     // of the prior, see NoiseModel

  /// State at any time from the first to the last; outside, the prior carries the end states on,
  /// with growing covariance. nullopt when there are no states.
  std::optional<StateAndCovariance> At(int64_t t_ns) const;
};

/// State dt_s after (before, when negative) `from`, by the prior alone.
StateAndCovariance Extrapolate(const StateAndCovariance& from, double dt_s, double accel_psd,
                               double angular_accel_psd);

}  // namespace tagtwist
