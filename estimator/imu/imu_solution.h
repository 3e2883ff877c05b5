#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/trajectory.h"
#include "estimator/imu/imu_factors.h"
#include "estimator/result/imu_result.h"
#include "estimator/solve/smoother.h"

namespace tagtwist::internal {

/// States with an IMU in the graph, and its calibration, found together.
struct ImuSolution {
  GraphInput input;
  NoiseModel noise;   // priors on acceleration of density 1, times what each interval has
  Solution solution;  // its covariance is given the calibration
  ImuModel model;
  ImuResult found;
  ImuStepCovariance calibration_covariance = ImuStepCovariance::Zero();
  /// What a unit of each of the calibration's independent errors does to all states, side by side:
  /// their second moment belongs to the covariance. In order of the columns of a lower triangular
  /// root of the calibration's covariance.
  std::vector<Eigen::VectorXd> shared_errors;
};

/// Adds the second moment of those errors.
void AddSharedErrors(const std::vector<Eigen::VectorXd>& errors, Trajectory* trajectory,
                     std::vector<StateCovariance>* covariances);

/// What all frames may be turned by alike the IMU's axes and gravity are taken for.
void Widen(double common_rotation_sigma_rad, ImuResult* found);

/// The prior on motion plays no part where the IMU measures it: on acceleration, of density 1.
NoiseModel WithImu(const NoiseModel& noise);

/// In words, one line.
std::string TextOf(const ImuResult& found);

}  // namespace tagtwist::internal
