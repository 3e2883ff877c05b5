#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/evaluation/comparison_key.h"
#include "estimator/evaluation/evaluation.h"
#include "estimator/evaluation/pose_series.h"
#include "estimator/result/estimate.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {
struct RunTally;
}  // namespace tagtwist::internal

namespace tagtwist {

/// One trajectory's line in the table of results.
struct ComparisonRow {
  std::string name;
  size_t frames = 0;                        // with a pose
  std::optional<Accuracy> accuracy;         // where there is truth
  std::optional<TwistRoughness> roughness;  // where there are twists
  ComparisonKey key = ComparisonKey::kNone;
};

ComparisonRow MakeComparisonRow(const std::string& name, const PoseSeries& series,
                                const std::vector<TruthSample>& truth,
                                const EvaluationOptions& options);

/// The methods of a run against each other: closed form plain, with RANSAC, with RANSAC and
/// low-pass; optimised; in window mode optimised at lag 0 and at the window's lag. Without truth
/// the rows have no accuracy. `all`: of the frames, where the estimate has but some of them: their
/// number and roughness are of all.
std::vector<ComparisonRow> CompareMethods(const Estimate& estimate,
                                          const std::vector<TruthSample>& truth,
                                          const EvaluationOptions& options,
                                          const internal::RunTally* all = nullptr);

/// A table of texts: the first row is the header.
using TextTable = std::vector<std::vector<std::string>>;

/// The figures as cells, "n/a" where there are none. With truth: frames, ATE, RPE over
/// options.rpe_seconds, RMSE of velocity and rate, NEES per degree of freedom; without: frames and
/// the roughness of velocity and rate.
TextTable ComparisonCells(const std::vector<ComparisonRow>& rows, double rpe_seconds);

/// What the columns mean, a line or two.
std::string ComparisonNotes(const std::vector<ComparisonRow>& rows);

/// The table as plain text, columns aligned, at most 100 wide, with the notes below.
std::string FormatComparisonTable(const std::vector<ComparisonRow>& rows, double rpe_seconds = 1);

}  // namespace tagtwist
