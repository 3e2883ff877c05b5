#pragma once
#include <optional>
#include <vector>

#include "estimator/graph_builder.h"
#include "frontend/steady_clock.h"
#include "frontend/types/measurements.h"
#include "residuals/motion_prior.h"

namespace tagtwist {

/// What of the motion is white noise, where the options leave it open: that under which the tags of
/// the recording's middle 300 frames with tags are likelier, the noise learned under each.
/// `frames`: seeds of the whole recording.
WhiteNoiseOn ChoosePrior(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames);

/// The steady clock fitted to the stamps, where the options ask for it or leave it open and the
/// tags of the first 300 frames are clearly likelier at its ticks; else nullopt: the stamps hold.
std::optional<SteadyClock> ChooseClock(const EstimatorSetup& setup,
                                       const std::vector<FrameMeasurements>& measurements);

/// The frames taken at other times.
std::vector<FrameMeasurements> AtTimes(const std::vector<int64_t>& t_ns,
                                       std::vector<FrameMeasurements> measurements);

}  // namespace tagtwist
