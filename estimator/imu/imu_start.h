#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/imu/imu_factors.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// What an IMU's calibration starts from.
struct ImuStart {
  ImuCalibration calibration;
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  ImuNoiseScale scale;  // ScaleOfScatter, where noise is to be learned
};

/// The options' densities in terms of what the samples scatter by from one to the next, beyond any
/// smooth motion: the median of their second differences. Shaking is in it, too; samples that were
/// smoothed have less. Within 1/20 and 20; 1 where there are too few.
ImuNoiseScale ScaleOfScatter(const ImuRecord& imu);

/// From frames with states that tags alone say: the clock by which the gyro's turns fit theirs best
/// (within 0.2 s of the options', where it may be refined and the turns tell), the gyro's mean
/// error, and gravity as what is left of the accelerations. Errors, in words for a person: no
/// interval between frames is covered; the axes are not the body's; what is left is not gravity.
Result<ImuStart> StartImu(const ImuRecord& imu, const std::vector<GraphFrame>& frames);

}  // namespace tagtwist::internal
