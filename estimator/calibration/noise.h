#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimator/calibration/normals.h"
#include "estimator/calibration/problem.h"

namespace tagtwist::internal {

/// Sums that the noise is learned from.
struct NoiseSums {
  double corner = 0, truth_position = 0, truth_rotation = 0;  // squares, robust, whitened
  double corner_redundancy = 0, truth_position_redundancy = 0, truth_rotation_redundancy = 0;
  // Correlation of a frame's error with the next one's.
  double truth_position_correlation = 0, truth_rotation_correlation = 0;
  int truth_frames = 0;
};
/// `covariance`: of the shared parameters, full layout, zero where they are held.
NoiseSums SumNoise(const CalibrationProblem& problem, const CalibrationState& state,
                   const std::vector<CalibrationFrame>& frames, const CalibrationNoise& noise,
                   const CalibrationNormals& normals, const Eigen::MatrixXd& covariance);

}  // namespace tagtwist::internal
