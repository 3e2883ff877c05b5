#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/calibration.h"
#include "estimator/comparison_table.h"
#include "estimator/estimate.h"
#include "estimator/summary_json.h"
#include "frontend/types/body_state.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

/// What a report tells besides the estimate.
struct ReportInput {
  RunFacts facts;
  TagMap map;
  std::vector<TruthSample> truth;   // empty when there is none
  std::vector<ComparisonRow> rows;  // as CompareMethods gives them
  std::optional<Calibration> calibration;
};

/// report.html: one file that opens without a network. Words, the table of methods, the trajectory
/// from above over the tags, plots over time with 3-sigma bands, errors, bound, counts,
/// reprojection, times.
std::string FormatReport(const Estimate& estimate, const ReportInput& input);

}  // namespace tagtwist
