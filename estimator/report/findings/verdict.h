#pragma once
#include <string>
#include <vector>

#include "estimator/report/findings/findings.h"
#include "estimator/result/estimate.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// One sentence or two: whether an estimate can be relied on, what speaks against it first, and
/// what the recording was too short to tell. `findings`: those of Findings, for the same truth;
/// `doubts`: RunFacts', which go before them, for they are causes.
std::string VerdictText(const Estimate& estimate, const std::vector<Finding>& findings,
                        const std::vector<TruthSample>& truth,
                        const std::vector<std::string>& doubts = {});

}  // namespace tagtwist::internal
