#pragma once
#include <optional>
#include <vector>

#include "estimator/graph_builder.h"
#include "estimator/noise_learning.h"
#include "frontend/steady_clock.h"
#include "frontend/types/measurements.h"

namespace tagtwist {

/// The noise to begin with. Where the options leave open what of the motion is white noise: that
/// under which the tags of 300 frames spread over the recording are likelier, with the noise
/// learned on those. `frames`: seeds of the whole recording.
NoiseModel ChooseNoise(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames);

/// The steady clock fitted to the stamps, where the options ask for it or leave it open and the
/// tags of the first 300 frames are clearly likelier at its ticks; else nullopt: the stamps hold.
std::optional<SteadyClock> ChooseClock(const EstimatorSetup& setup,
                                       const std::vector<FrameMeasurements>& measurements);

/// The frames taken at other times.
std::vector<FrameMeasurements> AtTimes(const std::vector<int64_t>& t_ns,
                                       std::vector<FrameMeasurements> measurements);

}  // namespace tagtwist
