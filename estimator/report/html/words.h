#pragma once
#include <string>

#include "estimator/report/html/report_input.h"
#include "estimator/result/estimate.h"

namespace tagtwist::internal {

/// The report before its plots, HTML: what was estimated, how good it is, what to look at (the
/// estimate's warnings, then Findings).
std::string ReportWordsHtml(const Estimate& estimate, const ReportInput& input);

}  // namespace tagtwist::internal
