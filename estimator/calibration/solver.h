#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimator/calibration/problem.h"

namespace tagtwist::internal {

/// A calibration's optimum.
struct CalibrationSolution {
  bool usable = false;
  CalibrationState state;
  std::vector<CalibrationFrame> frames;  // poses at the optimum
  CalibrationNoise noise;
  Eigen::MatrixXd covariance;  // by SolveAndLearnNoise: of the error state, full layout; zero where
                               // it is held
  double cost = 0;             // half the sum of squares, robust
  int iterations = 0;
};

/// Entries of the full layout that are refined: those with a prior sigma.
std::vector<int> FreeEntries(const Eigen::VectorXd& sigmas);

/// Refines shared parameters and frames' poses from `start` by Levenberg-Marquardt, the noise
/// known. Also with every parameter held: then the poses alone.
CalibrationSolution SolveCalibration(const CalibrationProblem& problem,
                                     const CalibrationState& start, const CalibrationNoise& noise);

/// SolveCalibration in turn with learning the noise: each sigma such that the squares of its
/// residuals agree with their redundancy. `learn_corners`: false keeps corner_sigma_px.
CalibrationSolution SolveAndLearnNoise(const CalibrationProblem& problem,
                                       const CalibrationState& start,
                                       const CalibrationNoise& initial, bool learn_corners);

}  // namespace tagtwist::internal
