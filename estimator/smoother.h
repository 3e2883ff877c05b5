#pragma once
#include <vector>

#include "estimator/block_banded.h"
#include "estimator/graph_builder.h"
#include "estimator/noise_learning.h"
#include "estimator/solver.h"
#include "frontend/types/result.h"

namespace tagtwist {

/// A graph solved, with the covariance of its states within the band.
struct Solution {
  Graph graph;
  BlockBandedMatrix covariance{0, 0};
  /// Of the measurements given the noise, the states integrated out (Laplace), but for a constant
  /// that depends on the measurements alone.
  double log_likelihood = 0;
  double cost = 0;  // half the sum of squares, robust
};

/// Builds the graph of the input, solves it, and inverts its normal equations. What batch and
/// window do at every step.
Result<Solution> SolveAndInvert(const EstimatorSetup& setup, const NoiseModel& noise,
                                const GraphInput& input, const SolveOptions& options);

/// How well SolveAndLearn learns.
struct LearnOptions {
  double settled = 0.005;  // change of a standard deviation, relative, that is none
  double least_dof = 1;    // see UpdateNoise
};

/// SolveAndInvert again and again, the noise updated in between until it settles; starts from
/// input's states and `noise`, leaves the last states and noise there. Track segments that a round
/// contradicts are taken out of the input. Where the time is up the last round's solution comes,
/// and the noise that it has led to.
Result<Solution> SolveAndLearn(const EstimatorSetup& setup, const SolveOptions& options,
                               GraphInput* input, NoiseModel* noise,
                               const LearnOptions& learn = {});

/// A measurement whose Huber weight is below this contradicts the rest.
inline constexpr double kContradictedWeight = 0.6;

/// Tags that the solution contradicts, as state and index in its frame.
struct TagRef {
  int state = 0, tag = 0;
};
std::vector<TagRef> ContradictedTags(const Graph& graph);
/// Takes those tags out of their frames.
void DropTags(std::vector<TagRef> tags, std::vector<GraphFrame>* frames);

/// Which of n segments the solution contradicts in some view: a moving object, a slipped track.
std::vector<bool> ContradictedSegments(const Graph& graph, size_t n);

/// Covariance of a state's BodyState.
StateCovariance BodyCovariance(const BlockBandedMatrix& covariance, int state);

/// A frame of the result.
FrameEstimate ToFrameEstimate(const ClosedForm& closed_form, int n_tracks, const GraphFrame& frame,
                              const StateCovariance& covariance);

/// Distance of every accepted corner from its prediction [px], frame by frame.
std::vector<double> ReprojectionErrors(const EstimatorSetup& setup, const GraphFrame& frame);

}  // namespace tagtwist
