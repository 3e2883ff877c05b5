#pragma once
#include <memory>

#include "apps/estimate/estimate_job.h"
#include "estimator/online/config.h"
#include "estimator/report/result_rows.h"
#include "estimator/report/result_writer.h"

namespace tagtwist::internal {

/// The rows that a job asks for.
RowsAsked RowsOf(const EstimateJob& job, const Config& config);

/// A window's states go into their files as they come, and those that a long run does without are
/// not kept. `rows` must outlive the run.
void WriteAsTheyCome(const EstimateJob& job, ResultRows* rows, RunOptions* options);

/// All files of a run, with the rows of a batch, which are none of those yet.
Status WriteResultsOf(const EstimateJob& job, std::unique_ptr<ResultRows> rows,
                      const Estimate& estimate, const ResultContext& context);

}  // namespace tagtwist::internal
