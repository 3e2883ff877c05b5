#pragma once
#include <iosfwd>

#include "apps/estimate/doubts.h"
#include "apps/estimate/estimate_flags.h"
#include "estimator/report/result_writer.h"

namespace tagtwist::internal {

/// Tells findings, figures and where the report is; returns how the run has gone.
Outcome TellResults(const EstimateJob& job, const Estimate& estimate, const ResultContext& context,
                    std::ostream* told);

/// The error of a run that failed, with what may have caused it; summary.json has it, too.
Error FailureOf(const EstimateJob& job, const Error& error, const Inputs& taken,
                const Doubts& doubts, const RunFacts& facts);

}  // namespace tagtwist::internal
