#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "estimator/batch/rig/rig_calibration.h"

namespace tagtwist::internal {

/// calibration.yaml of a rig: `sections`, the refined set-up as a configuration that LoadConfig
/// reads, below what was found, in comments.
std::string FormatRigConfig(const RigCalibration& rig, const std::string& sections);

/// The section `calibration` of summary.json (docs/formats.md).
nlohmann::ordered_json RigJson(const RigCalibration& rig);

}  // namespace tagtwist::internal
