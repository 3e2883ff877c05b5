#pragma once
#include <optional>

#include "estimator/graph/estimator_options.h"
#include "estimator/graph/noise_model.h"
#include "estimator/result/estimate.h"
#include "estimator/solve/noise_statistics.h"

namespace tagtwist::internal {

/// Whether the options leave open what of the motion is white noise.
bool MotionPriorIsOpen(const EstimatorOptions& options);

/// Whether both densities of the motion prior are learned.
bool MotionIsLearned(const EstimatorOptions& options);

/// Whether the options leave any noise to be learned where there are no tracks.
bool AnyNoiseIsOpen(const EstimatorOptions& options);

/// Noise to begin with: given values, defaults elsewhere; source "default" or "given". Where the
/// options leave the motion prior open it is `open`.
NoiseModel InitialNoise(const EstimatorOptions& options, WhiteNoiseOn open = WhiteNoiseOn::kJerk);

/// Noise from statistics, given values kept; a step changes a parameter at most tenfold. A source
/// with fewer than `least_dof` degrees of freedom keeps its value. A density stays above where its
/// information would drown the measurements' in rounding.
NoiseModel UpdateNoise(const NoiseModel& noise, const NoiseStatistics& statistics,
                       const EstimatorOptions& options, double least_dof = 1);

/// Largest change of a parameter between two models, as |log ratio| of standard deviations.
double NoiseChange(const NoiseModel& a, const NoiseModel& b);

}  // namespace tagtwist::internal
