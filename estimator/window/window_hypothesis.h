#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/motion/bank/motion_history.h"
#include "estimator/solve/quadratic_chain.h"
#include "estimator/solve/smoother.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// One account of the window's frames. Where tags leave two poses open there are two of them, until
/// what comes in decides.
struct WindowHypothesis {
  GraphInput input;         // the frames, and the prior of those that left
  Solution solution;        // of the last solve
  double settled_cost = 0;  // of all that left, beyond what the prior still holds
  QuadraticChain chain;     // what the last solve was made with, if it was a step; it then has the
  bool is_step = false;     // prior
  double corner_sigma_px = 0;  // that the chain's tags have
  std::vector<int> revised;    // frames whose tags are no longer those of the chain
  MotionHistory motion;        // of the frames

  /// Half the sum of squares of all that came until now.
  double Cost() const { return settled_cost + solution.cost; }
  /// Makes `input` whole: after steps the chain has the prior.
  void TakePrior();
};

/// Where the last solution has a frame of the window: it may still hold a state that left, or,
/// after a failure, one that was taken back.
int InSolution(const WindowHypothesis& hypothesis, int frame);

/// Solves, and takes over states and solution; unchanged on an error.
Status SolveHypothesis(const EstimatorSetup& setup, const NoiseModel& noise,
                       const SolveOptions& options, WindowHypothesis* hypothesis);

/// The same by a chain, where the hypothesis is alone and no track is in it: costs are kept but for
/// a constant; what has left keeps the noise that it had.
Status StepHypothesis(const EstimatorSetup& setup, const NoiseModel& noise,
                      const SolveOptions& options, WindowHypothesis* hypothesis);

/// Whether a frame's tags, near its pose, say more than its motion does: they agree with one
/// another, or are of a tag that goes on from frame to frame, and leave no mirrored pose open: of
/// two poses the motion has to tell.
bool Outranks(const EstimatorSetup& setup, const NoiseModel& noise, const MotionHistory& motion,
              const GraphFrame& frame);

/// Takes out the tags that the solution contradicts, none where they are most of the newest
/// frame's: then its state is wrong rather than they. Nor those of another frame if they are most
/// of it and agree with one another (PoseMeasurement::is_consensus): they outrank what the motion
/// says. True where there were any.
bool DropContradicted(const EstimatorSetup& setup, const NoiseModel& noise,
                      WindowHypothesis* hypothesis);

/// Whether the solution contradicts most of the newest frame's tags though they agree with one
/// another.
bool NewestContradicts(const EstimatorSetup& setup, const NoiseModel& noise,
                       const WindowHypothesis& hypothesis);

/// The oldest state becomes part of the prior.
void MarginalizeOldest(WindowHypothesis* hypothesis);

/// Removes hypotheses that tell the same as a likelier one, or that a likelier one excludes; the
/// likeliest comes first. At least one stays.
void Prune(std::vector<WindowHypothesis>* hypotheses);

/// Probability of the second hypothesis against the first: exp(-d) / (1 + exp(-d)), d the
/// difference of their costs; 0 where there is one alone.
double DoubtOf(const std::vector<WindowHypothesis>& hypotheses);

}  // namespace tagtwist::internal
