#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "estimator/report/findings/comparison_table.h"
#include "estimator/result/estimate.h"
#include "estimator/result/run_facts.h"

namespace tagtwist::internal {

/// Indented text with a final line end; bytes that are not UTF-8 (of file names) are replaced.
/// Objects begin as Json::object(): a null that operator[] would make one is not whole, and ends
/// the process where it is destroyed, if memory ends just then.
std::string FormatJson(const nlohmann::ordered_json& json);

/// Median, 99th percentile and largest; null where nothing was measured.
nlohmann::ordered_json PercentilesJson(const std::vector<double>& values);

/// The figures of one trajectory; keys that truth cannot answer are absent.
nlohmann::ordered_json AccuracyJson(const Accuracy& accuracy);

/// {truth_from_world, body_from_marker: [x y z qx qy qz qw], time_offset_s}, and where they are
/// known `sigmas` of the same: [x y z tilt_x tilt_y tilt_z] (m, rad).
nlohmann::ordered_json AlignmentJson(const Alignment& alignment);

/// summary.json of a run that failed: status, error, warnings, what it took and from which files.
nlohmann::ordered_json FailureJson(const std::string& error,
                                   const std::vector<std::string>& warnings, const RunFacts& facts);

/// The whole of summary.json. `rows` as CompareMethods gives them: accuracy.closed_form is the full
/// method (RANSAC + low-pass), accuracy.optimised in window mode the state at lag 0.
nlohmann::ordered_json SummaryJson(const Estimate& estimate, const std::vector<ComparisonRow>& rows,
                                   const RunFacts& facts);

}  // namespace tagtwist::internal
