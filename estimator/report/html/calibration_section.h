#pragma once
#include "estimator/calibration/calibration.h"
#include "estimator/report/html/page.h"

namespace tagtwist::internal {

/// Section "Calibration": the words of CalibrationText, and the tags from above, each with how far
/// it lies above (+) or below (-) where the map had it [mm] and coloured by it.
ReportSection CalibrationSection(const Calibration& calibration);

}  // namespace tagtwist::internal
