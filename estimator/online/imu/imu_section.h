#pragma once
#include <string>

#include "estimator/imu/imu_options.h"
#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/setup/yaml_value.h"

namespace tagtwist::internal {

/// The section `imu`: its keys, and those of a calibration's `file` before them: Kalibr's imu.yaml,
/// bare or below imu0, or EuRoC's imu0/sensor.yaml. An error: a file without a noise density, or
/// whose transform says that the IMU is not the body.
Status ReadImu(const YamlValue& node, const Limits& limits, ImuOptions* options);

}  // namespace tagtwist::internal
