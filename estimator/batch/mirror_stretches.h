#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/start/mirror.h"

namespace tagtwist::internal {

/// A run of frames whose tags alone leave two poses open (GraphFrame::leaves_open), or lie where
/// both are one, and the stretches of it that may as well have been seen from the mirrored poses:
/// they begin and end at the run's ends, where the mirrored pose comes near, and where the states
/// jump to it. By half the sum of squares that each frame's tags pay for the other minimum no
/// stretch is excluded.
struct OpenRun {
  FrameRange frames;
  std::vector<FrameRange> stretches;  // the likelier first
};

/// Of solved frames. Takes time only where a frame leaves two poses open.
std::vector<OpenRun> FindOpenRuns(const EstimatorSetup& setup, const NoiseModel& noise,
                                  const std::vector<GraphFrame>& frames);

}  // namespace tagtwist::internal
