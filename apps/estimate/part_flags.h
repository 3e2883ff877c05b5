#pragma once
#include "apps/estimate/estimate_job.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// --from, --to, --only_detections and --pieces into a job that has all else; an error is a wrong
/// use of them.
Status PartFromFlags(EstimateJob* job);

}  // namespace tagtwist::internal
