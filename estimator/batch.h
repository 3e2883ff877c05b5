#pragma once
#include <vector>

#include "estimator/estimate.h"
#include "estimator/graph_builder.h"
#include "estimator/trajectory.h"
#include "frontend/types/measurements.h"
#include "frontend/types/result.h"

namespace tagtwist {

/// All that a batch run gives.
struct BatchResult {
  std::vector<FrameEstimate> frames;  // one a frame
  Trajectory trajectory;              // to ask between the frames
  NoiseModel noise;
  std::vector<double> reprojection_px;  // distance of every accepted corner from its prediction
  std::vector<std::string> warnings;
};

/// Refines a whole recording in one sparse problem; noise that is not given is learned from it.
/// An error when no frame has a usable tag, or the problem cannot be solved.
Result<BatchResult> RunBatch(const EstimatorSetup& setup,
                             const std::vector<FrameMeasurements>& measurements);

}  // namespace tagtwist
