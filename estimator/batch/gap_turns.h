#pragma once
#include <vector>

#include "estimator/batch/open_accounts.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/ceres_solver.h"
#include "estimator/solve/smoother.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A solution whose gaps (FindAndBridgeGaps) were each looked at by themselves. A gap takes the
/// density of the motion beside it, raised where the states on both sides are not to be had with
/// that: no measurement says what happened within. Where the body may have turned another way, by
/// whole turns more or less, that way is solved, too: where it is clearly likelier it takes the
/// place, and all is solved and the noise learned anew. `open`: the ways that are left. A recording
/// without gaps stays as it is.
Result<Solution> DecideGaps(const EstimatorSetup& setup, const SolveOptions& options,
                            const std::vector<FrameRange>& gaps, Solution solution,
                            GraphInput* input, NoiseModel* noise, std::vector<OpenAccounts>* open);

}  // namespace tagtwist::internal
