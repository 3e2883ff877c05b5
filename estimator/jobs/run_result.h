#pragma once
#include <vector>

#include "estimator/result/estimate.h"
#include "estimator/result/run_facts.h"

namespace tagtwist::internal {

/// What a run gives. The facts have no wall time and no memory: those are of the whole program.
struct RunResult {
  Estimate estimate;
  std::vector<BodyEstimate> of_others = {};  // of Config::bodies
  RunFacts facts;
};

}  // namespace tagtwist::internal
