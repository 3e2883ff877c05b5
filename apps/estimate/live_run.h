#pragma once
#include <memory>
#include <string>

#include "apps/estimate/estimate_flags.h"
#include "apps/support/clean_end.h"
#include "estimator/jobs/run_options.h"
#include "estimator/jobs/run_result.h"
#include "estimator/online/config.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// Puts a feed in the source's place, whose frames come when they come.
void MakeLive(const EstimateJob& job, std::unique_ptr<DataSource>* source, RunOptions* options,
              CleanEnd* end);

/// What there is to say of it at the end, in a line.
std::string LiveText(const LiveRun& live, size_t n_frames);

/// A run whose states go out as they come: --stream, --publish, --page, --record. `lost`: why
/// a file that was asked for lacks some.
Result<RunResult> RunAndPublish(const EstimateJob& job, DataSource* source, const Config& config,
                                const RunOptions& options, std::string* lost);

}  // namespace tagtwist::internal
