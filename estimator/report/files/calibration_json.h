#pragma once
#include <nlohmann/json_fwd.hpp>

#include "estimator/calibration/calibration.h"

namespace tagtwist::internal {

/// The section `calibration` of summary.json (docs/formats.md).
nlohmann::ordered_json CalibrationJson(const Calibration& calibration);

}  // namespace tagtwist::internal
