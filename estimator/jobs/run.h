#pragma once
#include <string>

#include "estimator/jobs/run_options.h"
#include "estimator/jobs/run_result.h"
#include "estimator/online/config.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// Estimates a whole recording, batch or window, with the time of every stage. An error when no
/// frame has a usable tag, naming `dataset`. The trajectory is left out: it would take several
/// times the memory of all else, and no file has it.
Result<RunResult> RunEstimate(const std::string& dataset, DataSource* source, const Config& config,
                              const RunOptions& options);

}  // namespace tagtwist::internal
