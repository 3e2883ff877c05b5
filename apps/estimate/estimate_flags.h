#pragma once
#include <string>

#include "apps/estimate/estimate_job.h"
#include "apps/support/usage.h"

namespace tagtwist::internal {

/// What tagtwist_estimate --help prints.
Usage EstimateUsage();

/// The job that the flags describe, or the flag that is wrong.
Result<EstimateJob> EstimateJobFromFlags();

/// Flags that stand for keys of the section `estimator` override the config's values; an error
/// names the flag whose value is out of range.
Status OverrideOptions(EstimatorOptions* options);

}  // namespace tagtwist::internal
