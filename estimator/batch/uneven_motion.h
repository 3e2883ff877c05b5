#pragma once
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/ceres_solver.h"
#include "estimator/solve/smoother.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A solution under one density of the motion prior for all of a recording, made anew with one for
/// each interval where the tags say so beyond doubt: where the poses that they tell alone are
/// likelier under a bank of densities than under the best single one, apart for the linear and the
/// angular part, and the whole solution is likelier, too. Densities that the options give stay.
/// Leaves the states and scales in `input`.
Result<Solution> LetMotionVary(const EstimatorSetup& setup, const SolveOptions& options,
                               Solution solution, GraphInput* input, NoiseModel* noise);

}  // namespace tagtwist::internal
