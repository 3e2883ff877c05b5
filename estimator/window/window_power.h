#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/result/estimate.h"
#include "estimator/solve/prior_power.h"

namespace tagtwist::internal {

/// PriorPower for a window, of stretches of the frames that left it: over a window alone the
/// prior cannot be judged. The work on a stretch, some milliseconds, is spread over the frames that
/// follow, which no stretch takes.
class WindowPower {
 public:
  /// The first frame of the window, smoothed, leaves it.
  void Add(const EstimatorSetup& setup, const NoiseModel& noise,
           const std::vector<GraphFrame>& window);
  /// The stretch ends: what follows is not its continuation.
  void Break() { stretch_.clear(); }
  /// What to multiply the standard deviations of a frame that leaves by: one value for the
  /// rotation, position, velocity and rate each. Ones until it is known. States with fewer frames
  /// after them resolve less of the motion, and where they cease to the density holds: they keep
  /// theirs.
  const StateVector& scale() const { return scale_; }

 private:
  void Finish();

  std::vector<GraphFrame> stretch_;
  size_t passed_over_ = 0;                  // frames yet to come before the next stretch
  std::optional<PriorPowerFinder> finder_;  // of the last stretch, while it is at work
  PowerStatistic statistic_;                // fading
  StateVector scale_ = StateVector::Ones();
};

}  // namespace tagtwist::internal
