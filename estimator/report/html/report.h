#pragma once
#include <string>

#include "estimator/report/html/report_input.h"
#include "estimator/result/estimate.h"

namespace tagtwist::internal {

/// report.html: one file that opens without a network. Words, the table of methods, the trajectory
/// from above over the tags, plots over time with 3-sigma bands, errors, bound, counts,
/// reprojection, times.
std::string FormatReport(const Estimate& estimate, const ReportInput& input);

}  // namespace tagtwist::internal
