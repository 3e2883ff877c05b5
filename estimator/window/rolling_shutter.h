#pragma once
#include "estimator/graph/graph_builder.h"
#include "estimator/window/fixed_lag_smoother.h"
#include "frontend/base/result.h"
#include "frontend/base/time_up.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Undoes a rolling shutter frame by frame, for a sliding window. The motion is that of a window
/// of its own, which takes the corners as they are: its poses are those of the mean row, but their
/// twist and acceleration are right, and know nothing of what is undone by them. Those that do know
/// feed back into themselves, and run away.
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
