#pragma once
#include <optional>
#include <string>

#include "estimator/calibration/calibration.h"

namespace tagtwist::internal {

/// What the estimate is to know of a refined set-up: of the focal length, relative, and of each
/// coordinate of a tag's place [m]; nullopt where it was held.
struct RefinedSigmas {
  std::optional<double> focal, tag_m;
};
RefinedSigmas SigmasOf(const Calibration& calibration);

/// calibration.yaml: the refined set-up as a configuration that LoadConfig reads, with all options
/// of the one it came from, and with SigmasOf it; what changed and all sigmas are in its comments.
std::string FormatCalibrationConfig(const Calibration& calibration, const std::string& options);

/// The section `camera` of that configuration, its sigmas times `inflation`.
std::string CameraText(const Calibration& calibration, double inflation = 1);

}  // namespace tagtwist::internal
