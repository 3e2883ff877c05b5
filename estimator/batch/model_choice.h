#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/start/steady_clock.h"

namespace tagtwist::internal {

/// The steady clock fitted to the frames' stamps, where the options ask for it or leave it open and
/// the tags of the first 300 frames are clearly likelier at its ticks; else nullopt: the stamps
/// hold. `frames`: starts of the whole recording. Learning starts from `noise`, and leaves there
/// what it found.
std::optional<SteadyClock> ChooseClock(const EstimatorSetup& setup,
                                       const std::vector<GraphFrame>& frames, NoiseModel* noise);

/// The frames taken at other times.
void TakeAtTimes(const std::vector<int64_t>& t_ns, std::vector<GraphFrame>* frames);

/// The noise to begin with, learned from a few frames. Where the options leave open what of the
/// motion is white noise: that under which the tags of 300 frames spread over the recording are
/// likelier, with the noise learned on those. `frames`: starts of the whole
/// recording; `start`: noise that learning may start from, as the options say it or else under
/// white jerk; InitialNoise where there is none.
NoiseModel ChooseNoise(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames,
                       const std::optional<NoiseModel>& start = {});

}  // namespace tagtwist::internal
