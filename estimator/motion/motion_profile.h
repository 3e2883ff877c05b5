#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/motion/bank/motion_history.h"

namespace tagtwist::internal {

/// The history of these frames; keeps_past where the first ones are to be dropped later.
MotionHistory HistoryOf(const EstimatorSetup& setup, const NoiseModel& noise,
                        const std::vector<GraphFrame>& frames, bool keeps_past);

/// The parts whose density the options do not give.
MotionParts LearnedParts(const EstimatorOptions& options);
/// Those of them that have a density of their own in each interval, of which the history says so.
MotionParts VaryingParts(const MotionHistory& history, const EstimatorOptions& options);

/// Gives every frame of the history the scale of its motion, in multiples of the noise's densities:
/// as it is known from both sides where it varies, one where it does not.
void TakeMotion(const MotionHistory& history, const NoiseModel& noise, const MotionParts& varying,
                std::vector<GraphFrame>* frames);

}  // namespace tagtwist::internal
