#pragma once
#include <string>

#include "estimator/calibration/calibration.h"

namespace tagtwist::internal {

/// calibration.yaml: the refined set-up as a configuration that LoadConfig reads, with all options
/// of the one it came from; what changed and the sigmas are in its comments.
std::string FormatCalibrationConfig(const Calibration& calibration, const std::string& options);

/// The section `camera` of that configuration, its sigmas times `inflation`.
std::string CameraText(const Calibration& calibration, double inflation = 1);

}  // namespace tagtwist::internal
