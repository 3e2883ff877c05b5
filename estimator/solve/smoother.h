#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/linear/block_banded.h"
#include "estimator/result/estimate.h"
#include "estimator/solve/ceres_solver.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A graph solved, with the covariance of its states within the band.
struct Solution {
  Graph graph;
  BlockBandedMatrix covariance{0, 0};
  /// Likelihood of the measurements given the noise, the states integrated out (Laplace), but for a
  /// constant that depends on the measurements alone.
  double log_likelihood = 0;
  double cost = 0;  // half the sum of squares, robust
};

/// Builds the graph of the input, solves it, and inverts its normal equations. What batch and
/// window do at every step.
Result<Solution> SolveAndInvert(const EstimatorSetup& setup, const NoiseModel& noise,
                                const GraphInput& input, const SolveOptions& options);

/// Covariance of a state's BodyState.
StateCovariance BodyCovariance(const BlockBandedMatrix& covariance, int state);

/// A frame of the result.
FrameEstimate ToFrameEstimate(const ClosedForm& closed_form, int n_tracks, const GraphFrame& frame,
                              const StateCovariance& covariance);
/// The row of a frame before the first state.
FrameEstimate WithoutState(const FrameMeasurements& measurement);

}  // namespace tagtwist::internal
