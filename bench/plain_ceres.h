#pragma once
#include <vector>

#include "estimator/graph_builder.h"

namespace tagtwist {

/// How a plain solve went.
struct PlainCeresRun {
  double build_ms = 0, solve_ms = 0;  // wall time: making the ceres::Problem, solving it
  int iterations = 0;
  bool usable = false;
};

/// The batch problem as one would write it down first: poses and twists, a residual block for every
/// corner and every pair of neighbours (white noise on acceleration), all by automatic
/// differentiation, Huber's loss, sparse Cholesky, Ceres' own tolerances. Refines the frames'
/// states in place; no covariance.
PlainCeresRun SolvePlainly(const EstimatorSetup& setup, const NoiseModel& noise, int threads,
                           std::vector<GraphFrame>* frames);

}  // namespace tagtwist
