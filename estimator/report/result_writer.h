#pragma once
#include <memory>
#include <string>
#include <vector>

#include "estimator/report/findings/comparison_table.h"
#include "estimator/result/estimate.h"
#include "estimator/result/run_facts.h"
#include "frontend/base/result.h"
#include "frontend/types/body_state.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {
struct Calibration;
struct GyroAlignment;
struct RigCalibration;
struct Mapping;
class ResultRows;
}  // namespace tagtwist::internal

namespace tagtwist {

/// What goes into an output folder besides the estimate.
struct ResultContext {
  RunFacts facts;
  TagMap map;                       // drawn in the report,
  bool map_moves = false;           // unless its tags are on the body
  std::vector<TruthSample> truth;   // empty when there is none
  std::vector<ComparisonRow> rows;  // as CompareMethods gives them
  bool write_covariance = false;
  std::shared_ptr<const internal::Calibration> calibration;  // where one was asked for
  std::shared_ptr<const internal::RigCalibration> rig;       // of several cameras, likewise
  std::string options_text;  // with them: the configuration's other sections, of a rig all
  std::shared_ptr<const internal::Mapping> mapping;  // of tags that the map lacked, where asked for
  std::shared_ptr<const internal::GyroAlignment>
      gyro;                             // where asked for, and the recording has one
  std::vector<int> movable_tags;        // passed over
  std::vector<BodyEstimate> of_others;  // of bodies besides the estimate's own,
  std::string body;                     // which has that name; empty: none
  std::vector<std::string> kept;        // names of older runs' files that are not removed
};

/// Writes closed_form.tum, optimised.tum, states.csv, summary.json, report.html; with truth
/// ground_truth.tum, and ground_truth_states.csv where it has twists; in window mode
/// states_lagged.csv; when asked covariance.csv (and covariance_lagged.csv), calibration.yaml,
/// map.yaml, detections.csv; of several bodies each one's states_NAME.csv, optimised_NAME.tum and
/// what of the others was asked for likewise (BodyFileNames). All of them or none, see FileSet;
/// files of that list that this run does not have are removed, except those of `context.kept`. Two
/// runs with the same estimate differ in wall_s, peak_rss_mib and the times alone.
Status WriteResults(const std::string& folder, const Estimate& estimate,
                    const ResultContext& context);
/// The same, whose rows are written already: of a run with many frames, as they came.
Status WriteResults(const std::string& folder, std::unique_ptr<internal::ResultRows> rows,
                    const Estimate& estimate, const ResultContext& context);

/// summary.json alone, of a run that failed (FailureJson). A folder that holds an earlier run's
/// results is left as it is.
Status WriteFailure(const std::string& folder, const std::string& error,
                    const std::vector<std::string>& warnings, const RunFacts& facts);

}  // namespace tagtwist
