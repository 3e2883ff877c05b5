#pragma once
#include "estimator/graph/noise_model.h"
#include "estimator/linear/block_banded.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/quadratic_chain.h"
#include "frontend/base/for_ranges.h"

namespace tagtwist::internal {

/// ComputeNoiseStatistics of all states of a chain: tags by their forms as they are, where these
/// tell all that is asked.
NoiseStatistics ComputeNoiseStatistics(const QuadraticChain& chain,
                                       const BlockBandedMatrix& covariance, const NoiseModel& noise,
                                       const ForRanges& for_ranges);

}  // namespace tagtwist::internal
