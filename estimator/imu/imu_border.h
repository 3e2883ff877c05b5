#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/imu/imu_factors.h"

namespace tagtwist::internal {

/// What a graph whose states are solved says of an IMU's calibration, the states eliminated.
struct ImuBorder {
  ImuStep step = ImuStep::Zero();  // Gauss-Newton, from the calibration as it is
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// Of ImuSolution.
  std::vector<Eigen::VectorXd> shared_errors;

  /// The longest step of an entry, in its standard deviations.
  double StepInSigmas() const;
};

/// `frames` have the factors of that model, `graph` is of them, solved; `reference` is what the
/// options' sigmas are about. nullopt where the normal equations are not positive definite.
std::optional<ImuBorder> MakeBorder(const ImuRecord& imu, const ImuModel& model,
                                    const ImuCalibration& reference,
                                    const std::vector<GraphFrame>& frames, const Graph& graph);

}  // namespace tagtwist::internal
