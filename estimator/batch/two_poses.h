#pragma once
#include <vector>

#include "estimator/batch/mirror_stretches.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/trajectory.h"
#include "estimator/result/estimate.h"
#include "estimator/solve/ceres_solver.h"
#include "estimator/solve/smoother.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Another account of a stretch of states: some of its frames were seen from the mirrored poses.
struct OtherAccount {
  std::vector<GraphState> states;
  std::vector<Block> covariances, cross_covariances;  // as in Trajectory
  double gain = 0;  // logarithm of its likelihood over that of the account that is kept
};

/// Accounts of the same stretch that the recording does not decide.
struct OpenAccounts {
  int first = 0;   // the state that they begin with
  FrameRange run;  // the states that they tell differently
  std::vector<OtherAccount> others;
};

/// A solution whose runs of open frames (FindOpenRuns) were each compared with the other accounts
/// of them, solved under the same noise: where one is clearly likelier it takes the place, and all
/// is solved and the noise learned anew. `open`: the accounts that are left, not less likely than
/// exp(-kDecidedCost). A recording without open frames stays as it is.
Result<Solution> DecideTwoPoses(const EstimatorSetup& setup, const SolveOptions& options,
                                Solution solution, GraphInput* input, NoiseModel* noise,
                                std::vector<OpenAccounts>* open);

/// The covariances become those of the mixture about the states that are kept: sum of w (P + d d'),
/// d an account's difference. `covariances`: one a state, of BodyState. True for each state that
/// another account has elsewhere, by 5 degrees.
std::vector<bool> CoverTwoPoses(const std::vector<OpenAccounts>& open, Trajectory* trajectory,
                                std::vector<StateCovariance>* covariances);

/// The status of those frames; one that has no state (-1) lies between those before and after it.
void TellAmbiguous(const std::vector<bool>& ambiguous, const std::vector<int>& state_of_frame,
                   std::vector<FrameEstimate>* frames);

}  // namespace tagtwist::internal
