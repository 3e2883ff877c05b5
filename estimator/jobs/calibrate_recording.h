#pragma once
#include <string>
#include <vector>

#include "estimator/batch/rig/rig_calibration.h"
#include "estimator/calibration/calibration.h"
#include "estimator/jobs/run.h"
#include "estimator/online/config.h"

namespace tagtwist::internal {

/// The tags of every frame of a recording, without tracks. A progress bar of that label runs on a
/// terminal.
Result<std::vector<FrameMeasurements>> MeasureRecording(const std::string& label,
                                                        DataSource* source, const Config& config,
                                                        const RunOptions& options);

/// Measures a whole recording and calibrates by it. Errors name `dataset`.
Result<Calibration> CalibrateRecording(const std::string& dataset, DataSource* source,
                                       const Config& config, const RunOptions& options,
                                       const std::vector<TruthSample>& truth);

/// The same of a rig of several cameras: how they stand against the first, and their clocks.
Result<RigCalibration> CalibrateRigRecording(const std::string& dataset, DataSource* source,
                                             const Config& config, const RunOptions& options);

}  // namespace tagtwist::internal
