#pragma once
#include <memory>

#include "apps/estimate/estimate_job.h"
#include "estimator/online/config.h"
#include "estimator/report/result_writer.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// With --calibrate: the set-up is refined first, told, and the run goes on with it; `source` is
/// then open by it. --tracks is of this run alone: what is written goes on with what the
/// configuration said.
Status CalibrateIfAsked(const EstimateJob& job, bool configured_tracks, Config* config,
                        std::unique_ptr<DataSource>* source, ResultContext* context);

}  // namespace tagtwist::internal
