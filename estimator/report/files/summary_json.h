#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "estimator/report/findings/comparison_table.h"
#include "estimator/result/estimate.h"

namespace tagtwist {

/// Facts of a run that the estimate does not know.
struct RunFacts {
  std::string dataset;      // as the user named it
  double wall_s = 0;        // from start to the writing of the results
  double peak_rss_mib = 0;  // largest memory held so far
};

/// Indented text with a final line end; bytes that are not UTF-8 (of file names) are replaced.
std::string FormatJson(const nlohmann::ordered_json& json);

/// Median, 99th percentile and largest; null where nothing was measured.
nlohmann::ordered_json PercentilesJson(const std::vector<double>& values);

/// The figures of one trajectory; keys that truth cannot answer are absent.
nlohmann::ordered_json AccuracyJson(const Accuracy& accuracy);

/// {truth_from_world, body_from_marker: [x y z qx qy qz qw], time_offset_s}, and where they are
/// known `sigmas` of the same: [x y z tilt_x tilt_y tilt_z] (m, rad).
nlohmann::ordered_json AlignmentJson(const Alignment& alignment);

/// The whole of summary.json. `rows` as CompareMethods gives them: accuracy.closed_form is the full
/// method (RANSAC + low-pass), accuracy.optimised in window mode the state at lag 0.
nlohmann::ordered_json SummaryJson(const Estimate& estimate, const std::vector<ComparisonRow>& rows,
                                   const RunFacts& facts);

}  // namespace tagtwist
