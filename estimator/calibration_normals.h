#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimator/calibration_problem.h"

namespace tagtwist {

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
  bool ok = false;  // false: something cannot be evaluated here
  double cost = 0;  // half the sum of squares, robust
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

/// A frame's part of the cost; nullopt where it cannot be evaluated.
std::optional<double> FrameCost(const CalibrationProblem& problem, const CalibrationState& state,
                                const CalibrationFrame& frame, const CalibrationNoise& noise);

/// Sums that the noise is learned from.
struct NoiseSums {
  double corner = 0, truth_position = 0, truth_rotation = 0;  // squares, robust, whitened
  double corner_redundancy = 0, truth_position_redundancy = 0, truth_rotation_redundancy = 0;
  // Of a frame's error with the next one's.
  double truth_position_correlation = 0, truth_rotation_correlation = 0;
  int truth_frames = 0;
};
/// `covariance`: of the shared parameters, full layout, zero where they are held.
NoiseSums SumNoise(const CalibrationProblem& problem, const CalibrationState& state,
                   const std::vector<CalibrationFrame>& frames, const CalibrationNoise& noise,
                   const CalibrationNormals& normals, const Eigen::MatrixXd& covariance);

}  // namespace tagtwist
