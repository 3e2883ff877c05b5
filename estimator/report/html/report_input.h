#pragma once
#include <optional>
#include <vector>

#include "estimator/calibration/calibration.h"
#include "estimator/report/files/summary_json.h"
#include "estimator/report/findings/comparison_table.h"
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

}  // namespace tagtwist
