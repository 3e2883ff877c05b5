#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "estimator/evaluation/comparison_key.h"
#include "estimator/result/estimate.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// Least error that can be expected: root mean square over frames of the 3-D standard deviation,
/// the square root of the trace of a part of the covariance.
struct ErrorBound {
  size_t frames = 0;        // that it is over; without any the figures mean nothing
  double position_m = 0;    // in W
  double rotation_rad = 0;  // angle
  double velocity_mps = 0;  // in W
  double rate_radps = 0;    // in B
};

/// Over covariances of the error state of BodyState.
ErrorBound RmsBound(const std::vector<StateCovariance>& covariances);

/// The bounds of a result. In window mode of the frames at the window's lag: at lag 0 the first
/// frames know next to nothing of their motion yet, and would be all that a mean shows.
struct EstimateBounds {
  /// From each frame's tags alone, over the frames whose tags fix the pose; no twist, for one frame
  /// says nothing of motion.
  ErrorBound frame;
  /// From the whole estimate, over the frames with a state: the posterior covariance of the solved
  /// graph, which is the posterior Cramér-Rao bound where noise and motion are as modelled.
  ErrorBound smoothed;
  ComparisonKey key = ComparisonKey::kOptimised;  // the trajectory that `smoothed` is of
};
EstimateBounds BoundsOf(const Estimate& estimate);

/// By how much standard deviations of the smoothed states shrink when the corner noise is halved,
/// or when four times as many corners are seen, in a long recording under a motion prior: the
/// pose's where corners fix it, and its rate's (maths.md, section 8).
struct HalfNoiseGain {
  double pose = 1, twist = 1;
};
HalfNoiseGain GainOfHalfNoise(WhiteNoiseOn on);

}  // namespace tagtwist::internal
