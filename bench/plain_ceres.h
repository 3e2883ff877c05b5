#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"

namespace tagtwist::internal {

/// The batch problem as one would write it down first: poses and twists, a residual block for every
/// corner and every pair of neighbours (white noise on acceleration), all by automatic
/// differentiation, Huber's loss, sparse Cholesky, Ceres' own tolerances. Refines the frames'
/// states in place; no covariance. One thread. False if Ceres finds no usable solution.
bool SolvePlainly(const EstimatorSetup& setup, const NoiseModel& noise,
                  std::vector<GraphFrame>* frames);

}  // namespace tagtwist::internal
