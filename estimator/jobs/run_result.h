#pragma once
#include "estimator/result/estimate.h"
#include "estimator/result/run_facts.h"

namespace tagtwist::internal {

/// What a run gives. The facts have no wall time and no memory: those are of the whole program.
struct RunResult {
  Estimate estimate;
  RunFacts facts;
};

}  // namespace tagtwist::internal
