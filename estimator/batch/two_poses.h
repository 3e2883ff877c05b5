#pragma once
#include <vector>

#include "estimator/batch/open_accounts.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/ceres_solver.h"
#include "estimator/solve/smoother.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A solution whose runs of open frames (FindOpenRuns) were each compared with the other accounts
/// of them, solved under the same noise: where one is clearly likelier it takes the place, and all
/// is solved and the noise learned anew. `open`: the accounts that are left, not less likely than
/// exp(-kDecidedCost). A recording without open frames stays as it is.
Result<Solution> DecideTwoPoses(const EstimatorSetup& setup, const SolveOptions& options,
                                Solution solution, GraphInput* input, NoiseModel* noise,
                                std::vector<OpenAccounts>* open);

}  // namespace tagtwist::internal
