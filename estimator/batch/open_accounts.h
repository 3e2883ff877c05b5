#pragma once
#include <vector>

#include "estimator/batch/mirror_stretches.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/trajectory.h"
#include "estimator/result/estimate.h"
#include "estimator/solve/smoother.h"

namespace tagtwist::internal {

/// Another account of a stretch of states: some of its frames were seen from the mirrored poses, or
/// the body turned another way within a gap.
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
  bool of_turns = false;         // they turn by other multiples of a whole turn
  double least_told_weight = 0;  // less likely accounts are in the covariance, not in the status
};

/// A run with the states beside it, as a problem of its own.
struct Stretch {
  FrameRange states;  // in the whole
  GraphInput input;
};

/// With so many states on either side, as far as there are.
Stretch Around(const GraphInput& whole, const FrameRange& run, int beside);

/// States within a standard deviation of one another: two minima that are none.
bool AreTheSame(const Solution& a, const std::vector<GraphState>& b);

OtherAccount AccountOf(const Solution& solution, double gain);

/// Half the sum of squares of the corners of these frames at the solution's states.
double CostOfCorners(const EstimatorSetup& setup, const NoiseModel& noise,
                     const std::vector<GraphFrame>& frames, const Solution& solution);

/// Puts the frames where likelier accounts have them, if they are clearly so; whether there were
/// any. The first of the others is the likeliest.
bool TakeLikelier(const std::vector<OpenAccounts>& open, GraphInput* input);

/// The covariances become those of the mixture about the states that are kept: sum of w (P + d d'),
/// d an account's difference. `covariances`: one a state, of BodyState. True for each state that
/// another account has elsewhere, by 5 degrees.
std::vector<bool> CoverOpenAccounts(const std::vector<OpenAccounts>& open, Trajectory* trajectory,
                                    std::vector<StateCovariance>* covariances);

/// The states beside each frame: that before and that after its time, or the one at it twice. -1
/// and the number of states where there is none.
std::vector<FrameRange> StatesAround(const std::vector<GraphState>& states,
                                     const std::vector<GraphFrame>& frames);

/// The status of frames beside which (StatesAround) a state is ambiguous.
void TellAmbiguous(const std::vector<bool>& ambiguous, const std::vector<FrameRange>& around,
                   std::vector<FrameEstimate>* frames);

}  // namespace tagtwist::internal
