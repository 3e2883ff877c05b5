#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/trajectory.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Where the solve may start for a new frame of the window, and which of its tags enter.
struct FrameStarts {
  /// Several where the tags leave several poses open and the motion does not decide; the likeliest
  /// first. Empty: no tag, and no frame before.
  std::vector<GraphFrame> starts;
  /// The pose that the tags say, where the motion excludes it. They are then left out, but for
  /// those that agree with the prediction.
  std::optional<Pose> excluded;
};

/// `last` is the newest frame of the window, nullptr without one; `predicted` what it says of this
/// one, nullopt where that is not to be relied upon: then no pose is excluded.
FrameStarts StartFrame(const EstimatorSetup& setup, const NoiseModel& noise,
                       const FrameMeasurements& measurement, const GraphFrame* last,
                       const std::optional<StateAndCovariance>& predicted);

}  // namespace tagtwist::internal
