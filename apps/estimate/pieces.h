#pragma once
#include "apps/estimate/estimate_flags.h"
#include "estimator/jobs/run_options.h"
#include "estimator/online/config.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// --only_detections: measures the corners of the job's frames, writes them as a piece, tells it.
Status MeasurePiece(const EstimateJob& job, const Config& config);

/// --pieces, where they are given: the tags of all frames of the recording into the options.
/// Refused where the pieces are not of it.
Status AddPieces(const EstimateJob& job, const Config& config, const DataSource& source,
                 RunOptions* options);

}  // namespace tagtwist::internal
