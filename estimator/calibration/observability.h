#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimator/calibration/problem.h"

namespace tagtwist::internal {

/// A direction of the parameters that the data left nearly where the prior had it.
struct UnseenDirection {
  double variance_ratio = 1;  // posterior over prior
  /// Kinds of parameters by their share in it, greatest first; shares below 5 % left out. "the map
  /// as a whole": all tags moved as one rigid body.
  struct Part {
    std::string kind;
    double share = 0;
  };
  std::vector<Part> parts;
};

/// Eigenvectors of the posterior covariance in units of the prior's sigmas whose variance is above
/// half of the prior's, greatest first. `covariance` and `prior_sigmas`: full layout.
std::vector<UnseenDirection> FindUnseen(const CalibrationState& reference,
                                        const std::vector<CalibrationParameter>& parameters,
                                        const Eigen::VectorXd& prior_sigmas,
                                        const Eigen::MatrixXd& covariance);

/// What would show a kind of parameter: "turns about two axes".
std::string WhatWouldShow(const std::string& kind);

/// Rigid motions of all free tags as one, orthonormal columns (up to 6) over the error state
/// divided by `units`, an entry each; where units is not positive the rows are zero.
Eigen::MatrixXd RigidMotionsOfMap(const CalibrationState& reference, const Eigen::VectorXd& units);

/// The map's size told by where the tags lie to each other, as a linear function of the error
/// state: the scale of the similarity that takes the reference's tag centres to the state's. Its
/// product with the covariance gives its sigma and its correlation with other parameters.
Eigen::VectorXd MapScaleDirection(const CalibrationState& reference,
                                  const Eigen::VectorXd& prior_sigmas);

}  // namespace tagtwist::internal
