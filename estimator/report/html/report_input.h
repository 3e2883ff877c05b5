#pragma once
#include <memory>
#include <vector>

#include "estimator/batch/rig/rig_calibration.h"
#include "estimator/calibration/calibration.h"
#include "estimator/report/findings/comparison_table.h"
#include "estimator/result/run_facts.h"
#include "frontend/types/body_state.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// What a report tells besides the estimate.
struct ReportInput {
  RunFacts facts;
  TagMap map;
  std::vector<TruthSample> truth;                  // empty when there is none
  std::vector<ComparisonRow> rows;                 // as CompareMethods gives them
  std::shared_ptr<const Calibration> calibration;  // where there is one
  std::shared_ptr<const RigCalibration> rig;       // likewise, of several cameras
  bool map_moves = false;                          // its tags are on the body
};

}  // namespace tagtwist::internal
