#pragma once
#include <string>
#include <vector>

#include "apps/run_estimate.h"
#include "estimator/calibration.h"

namespace tagtwist {

/// Measures a whole recording and calibrates by it. A progress bar runs on a terminal. Errors name
/// `dataset`.
Result<Calibration> CalibrateRecording(const std::string& dataset, DataSource* source,
                                       const Config& config, const RunOptions& options,
                                       const std::vector<TruthSample>& truth);

}  // namespace tagtwist
