#pragma once
#include <string>
#include <vector>

#include "estimator/report/files/result_reader.h"
#include "estimator/report/findings/comparison_table.h"

namespace tagtwist::internal {

/// Trajectories side by side, each with its figures.
struct Comparison {
  std::vector<NamedSeries> series;
  std::vector<ComparisonRow> rows;  // one a series
  std::vector<TruthSample> truth;   // empty when there is none
  std::string truth_path;
  EvaluationOptions options;
};

/// Judges every series. An error names the one that has no truth at its times, or too little to
/// be aligned.
Result<Comparison> Compare(std::vector<NamedSeries> series, std::vector<TruthSample> truth,
                           const std::string& truth_path, const EvaluationOptions& options);

/// JSON: {ground_truth, align, inputs: [{name, frames, accuracy, alignment, roughness}]}.
std::string FormatComparisonJson(const Comparison& comparison);

/// A page as report.html, with the aligned trajectories from above and over time.
std::string FormatComparisonReport(const Comparison& comparison);

}  // namespace tagtwist::internal
