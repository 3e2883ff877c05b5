#pragma once
#include "estimator/graph/graph_builder.h"
#include "estimator/solve/ceres_solver.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/smoother.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

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

}  // namespace tagtwist::internal
