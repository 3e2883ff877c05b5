#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/calibration/calibration.h"
#include "estimator/calibration/gyro_alignment.h"
#include "estimator/calibration/mapping.h"
#include "estimator/report/files/summary_json.h"
#include "estimator/report/findings/comparison_table.h"
#include "estimator/result/estimate.h"
#include "frontend/base/files/file_set.h"
#include "frontend/base/files/run_files.h"
#include "frontend/base/result.h"
#include "frontend/types/body_state.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

/// What goes into an output folder besides the estimate.
struct ResultContext {
  RunFacts facts;
  TagMap map;                       // drawn in the report
  std::vector<TruthSample> truth;   // empty when there is none
  std::vector<ComparisonRow> rows;  // as CompareMethods gives them
  bool write_covariance = false;
  std::optional<Calibration> calibration;  // where one was asked for
  std::string options_text;                // with it: the configuration's other sections
  std::optional<Mapping> mapping;          // of tags that the map lacked, where one was asked for
  std::optional<GyroAlignment> gyro;       // where one was asked for, and the recording has one
  std::vector<int> movable_tags;           // passed over
  std::vector<std::string> kept;           // names of older runs' files that are not removed
};

/// What of WriteResults' files a run may write.
struct ResultKinds {
  bool window = false, covariance = false, calibration = false, mapping = false;
};

/// The files of a run, and what of older runs goes where this run does not write it.
OutputSet ResultSet(const std::string& folder, const ResultKinds& kinds);

/// Writes closed_form.tum, optimised.tum, states.csv, summary.json, report.html; with truth
/// ground_truth.tum, and ground_truth_states.csv where it has twists; in window mode
/// states_lagged.csv; when asked covariance.csv (and covariance_lagged.csv), calibration.yaml,
/// map.yaml. All of them or none, see FileSet; files of that list that this run does not have are
/// removed, except those of `context.kept`. Two runs with the same estimate differ in wall_s,
/// peak_rss_mib and the times alone.
Status WriteResults(const std::string& folder, const Estimate& estimate,
                    const ResultContext& context);

}  // namespace tagtwist
