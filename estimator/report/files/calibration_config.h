#pragma once
#include <optional>
#include <string>

#include "estimator/calibration/calibration.h"

namespace tagtwist::internal {

/// What the estimate is to know of each coordinate of a refined tag's place [m]; nullopt where all
/// were held. What it is to know of lens and mount is in the refined camera (RigCamera).
std::optional<double> TagSigmaOf(const Calibration& calibration);

/// calibration.yaml: the refined set-up as a configuration that LoadConfig reads, with all options
/// of the one it came from, and with the sigmas of lens, mount and tags; what changed and all
/// sigmas are in its comments.
std::string FormatCalibrationConfig(const Calibration& calibration, const std::string& options);

/// The section `camera` of that configuration, its sigmas times `inflation`.
std::string CameraText(const Calibration& calibration, double inflation = 1);

}  // namespace tagtwist::internal
