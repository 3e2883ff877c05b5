#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/graph/graph_state.h"
#include "estimator/linear/block.h"
#include "frontend/types/body_state.h"
#include "residuals/motion_prior.h"

namespace tagtwist {

/// A state and its covariance (error state of BodyState).
struct StateAndCovariance {
  BodyState state;
  StateCovariance covariance = StateCovariance::Zero();
};

/// Smoothed states with what is needed to ask between them. The prior between neighbours is a
/// Gaussian process in continuous time, so that the trajectory is exact between the states,
/// covariance included (Barfoot, State Estimation for Robotics, ch. 11; Anderson and Barfoot 2015).
struct Trajectory {
  std::vector<GraphState> states;        // times strictly growing
  std::vector<Block> covariances;        // error state of GraphState
  std::vector<Block> cross_covariances;  // [k]: of state k + 1 (rows) with k
  MotionPrior linear, angular;           // times the scale of each interval, which the states have

  /// State at any time from the first to the last; outside, the prior carries the end states on,
  /// with growing covariance. nullopt when there are no states.
  std::optional<StateAndCovariance> At(int64_t t_ns) const;
};

}  // namespace tagtwist
