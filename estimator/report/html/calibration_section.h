#pragma once
#include "estimator/batch/rig/rig_calibration.h"
#include "estimator/calibration/calibration.h"
#include "estimator/report/html/page.h"

namespace tagtwist::internal {

/// Section "Calibration": the words of CalibrationText, and the tags from above, each with how far
/// it lies above (+) or below (-) where the map had it [mm] and coloured by it.
ReportSection CalibrationSection(const Calibration& calibration);
/// The same of a rig's mounts and clocks.
ReportSection RigSection(const RigCalibration& rig);

}  // namespace tagtwist::internal
