#pragma once
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/ceres_solver.h"
#include "estimator/solve/smoother.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// SolveAndLearn from where the tags put each frame by itself, under noise that was learned on some
/// of them. Where tags barely resolve the motion its density may have come out so small that the
/// scattered starts and it have no common solution, or only one with the corners far off: then
/// again, from the noise before anything is known; of both the likelier.
Result<Solution> SolveFromStarts(const EstimatorSetup& setup, const SolveOptions& options,
                                 GraphInput* input, NoiseModel* noise);

}  // namespace tagtwist::internal
