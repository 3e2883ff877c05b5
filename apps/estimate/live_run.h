#pragma once
#include <memory>
#include <string>

#include "apps/estimate/estimate_flags.h"
#include "apps/support/clean_end.h"
#include "estimator/jobs/run_options.h"
#include "estimator/jobs/run_result.h"
#include "estimator/live/live_feed.h"
#include "estimator/online/config.h"

namespace tagtwist::internal {

/// Puts a feed in the source's place, whose frames come when they come.
LiveFeed* MakeLive(const EstimateJob& job, std::unique_ptr<DataSource>* source, RunOptions* options,
                   CleanEnd* end);

/// What there is to say of it at the end, in a line.
std::string LiveText(const LiveRun& live, size_t n_frames);

/// A run whose states go out as they come: --stream, --publish, --page, --record. `feed`: where it
/// is live, else nullptr. `lost`: why a file that was asked for lacks some.
Result<RunResult> RunAndPublish(const EstimateJob& job, DataSource* source, const Config& config,
                                const RunOptions& options, const LiveFeed* feed, std::string* lost);

}  // namespace tagtwist::internal
