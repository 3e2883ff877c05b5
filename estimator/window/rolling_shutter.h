#pragma once
#include "estimator/graph/graph_builder.h"
#include "estimator/window/fixed_lag_smoother.h"
#include "frontend/base/result.h"
#include "frontend/base/time_up.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Undoes a rolling shutter frame by frame, for a sliding window. The twists are those of a window
/// of its own, which takes the corners as they are: its poses are those of some row, but their
/// twist is right, and knows nothing of what is undone by it. Twists that do know feed back into
/// themselves, and run away.
class RollingShutterUndo {
 public:
  explicit RollingShutterUndo(const EstimatorSetup& setup);
  /// Stamps must grow. As it is where there is no state.
  Result<FrameMeasurements> AsOfStamp(FrameMeasurements measurement, const TimeUp& time_up = {});

 private:
  EstimatorSetup setup_;
  FixedLagSmoother as_seen_;
};

}  // namespace tagtwist::internal
