#pragma once
#include "apps/simulate/simulate_job.h"
#include "apps/support/usage.h"

namespace tagtwist::internal {

/// What tagtwist_simulate --help prints.
Usage SimulateUsage();

/// The job that the flags describe, or the flag whose value is out of its range.
Result<SimulateJob> SimulateJobFromFlags();

}  // namespace tagtwist::internal
