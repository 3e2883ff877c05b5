#pragma once
#include <vector>

#include "estimator/batch/mirror_stretches.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/smoother.h"

namespace tagtwist::internal {

/// What the motion over a gap has of what the prior expects: sums in multiples of the density that
/// the gap has.
struct GapMotion {
  VarianceStatistic linear, angular;
};

/// Of a solution under that noise.
GapMotion MotionOver(const FrameRange& gap, const NoiseModel& noise, const Solution& solution);

/// The motion to each of the frames after the gap's first one.
void SetMotion(const FrameRange& gap, const MotionScale& motion, std::vector<GraphFrame>* frames);

/// What is to be expected within a gap before it is looked at: the livelier of what holds before
/// and after it, times what motion has over as long a time elsewhere in the recording, where that
/// is more than white noise from frame to frame says. `gaps`: all of the recording.
MotionScale ExpectedMotion(const std::vector<FrameRange>& gaps, const FrameRange& gap,
                           const NoiseModel& noise, const std::vector<GraphFrame>& frames);

}  // namespace tagtwist::internal
