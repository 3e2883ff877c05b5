#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimator/calibration/problem.h"

namespace tagtwist::internal {

/// What eliminating a frame's pose leaves: the step of the pose is -(offset + by_shared * d), d the
/// step of the shared parameters at `columns`.
struct EliminatedFrame {
  std::vector<int> columns;
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_shared;
  Eigen::Matrix<double, 6, 1> offset;
  Eigen::Matrix<double, 6, 6> covariance;  // of the pose, the shared parameters known
};

/// Normal equations of the shared parameters, full layout, the frames' poses eliminated by their
/// Schur complement; priors included.
struct CalibrationNormals {
  bool ok = false;       // false: something cannot be evaluated here
  double cost = 0;       // half the sum of squares, robust
  double pose_gain = 0;  // what moving the poses alone would take off it
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  std::vector<EliminatedFrame> frames;
};

/// Linearises at a state and at the frames' poses. `damping`: the diagonal of the poses' blocks
/// grows by that fraction before they are eliminated. O(frames * (entries of a frame's tags)^2).
CalibrationNormals LinearizeCalibration(const CalibrationProblem& problem,
                                        const CalibrationState& state,
                                        const std::vector<CalibrationFrame>& frames,
                                        const CalibrationNoise& noise, double damping);

}  // namespace tagtwist::internal
