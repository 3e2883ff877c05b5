#pragma once
#include <optional>
#include <string>

#include "estimator/graph/graph_builder.h"
#include "estimator/motion/repeated_images.h"
#include "estimator/window/fixed_lag_smoother.h"
#include "frontend/base/result.h"
#include "frontend/base/time_up.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Undoes a rolling shutter frame by frame, for a sliding window. The motion is that of a window
/// of its own, whose poses are those of the mean row: corners come to it as of that row where their
/// motion is known well enough, else as they are. Its twist and acceleration know nothing of what
/// brings corners to the stamp, which would feed back into itself, and run away. Where an image's
/// own rows exclude what that window predicts (RowMotionOfTags), they tell the motion: a body does
/// not stay at rest because it was.
class RollingShutterUndo {
 public:
  explicit RollingShutterUndo(const EstimatorSetup& setup);
  /// Stamps must grow. As it is where there is no state. An image that comes again is known here
  /// alone: undone as of another stamp it is another.
  Result<FrameMeasurements> AsOfStamp(FrameMeasurements measurement, const TimeUp& time_up = {});
  /// Of those.
  std::optional<std::string> Warning() const { return repeated_.Warning(); }

 private:
  EstimatorSetup setup_;
  RepeatedImages repeated_;
  FixedLagSmoother of_mean_row_;
};

}  // namespace tagtwist::internal
