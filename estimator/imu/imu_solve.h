#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/imu/imu_factors.h"
#include "estimator/imu/imu_solution.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Solves frames whose states tags alone have said, with an IMU besides: biases are states, and
/// gravity's direction, the IMU's clock and its axes are found with them (Gauss-Newton, the states
/// eliminated); its noise where that is to be learned, by the likelihood. Frames without tags start
/// where the IMU carries the state before them to. Tags as in the frames; `noise` gives their
/// corners' noise. Tracks are not used. `known`: what was found before, of nearly the same frames,
/// to start from. Without `by_likelihood` noise that is to be learned is what samples scatter by.
Result<ImuSolution> SolveWithImu(const EstimatorSetup& setup, const NoiseModel& noise,
                                 const ImuRecord& imu, std::vector<GraphFrame> frames,
                                 const ImuModel* known = nullptr, bool by_likelihood = true);

}  // namespace tagtwist::internal
