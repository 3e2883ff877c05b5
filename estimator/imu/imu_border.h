#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/imu/imu_factors.h"
#include "residuals/imu_residual.h"

namespace tagtwist::internal {

/// What a graph whose states are solved says of an IMU's calibration, the states eliminated.
struct ImuBorder {
  ImuStep step = ImuStep::Zero();  // Gauss-Newton, from the calibration as it is
  ImuStepCovariance covariance = ImuStepCovariance::Zero();
  /// Of ImuSolution.
  std::vector<Eigen::VectorXd> shared_errors;

  /// The longest step of an entry, in its standard deviations.
  double StepInSigmas() const;
};

/// A factor's residual as it was made (ShiftedResidual).
std::shared_ptr<const ceres::CostFunction> AtFirst(const Factor& factor);

/// Derivative of a factor's residual by the calibration's error state, rows x 9, of all but those
/// of tags; `by_states` is that by its blocks, as of LinearizeFactor. A clock that is moved is as
/// good as states that are moved on the other way, each by its own rates: so what tags say of these
/// tells it, and nothing else, the motion's prior neither. Where the noise of rates met that prior,
/// or the samples' own met how fast they change, it looked like a clock that is off.
Eigen::MatrixXd ByCalibration(const Factor& factor, const Eigen::MatrixXd& by_states,
                              const Graph& graph, const ImuCalibration& calibration);

/// `graph` has the factors of that model and is solved; `reference` is what the options' sigmas are
/// about. nullopt where the normal equations are not positive definite.
std::optional<ImuBorder> MakeBorder(const ImuOptions& options, const ImuModel& model,
                                    const ImuCalibration& reference, const Graph& graph);

}  // namespace tagtwist::internal
