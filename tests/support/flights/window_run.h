#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/window/sliding_window.h"

namespace tagtwist::internal {

/// What a window says of a recording: each frame once at its arrival, and once at the lag.
struct WindowRun {
  std::vector<FrameEstimate> current, lagged;
};

/// Fails the test where the window does.
WindowRun RunWindow(const EstimatorSetup& setup,
                    const std::vector<FrameMeasurements>& measurements);

}  // namespace tagtwist::internal
