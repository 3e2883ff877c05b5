#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "estimator/evaluation/error_bound.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/report/findings/comparison_table.h"
#include "frontend/base/result.h"
#include "tests/support/flights/bench_flights.h"

namespace tagtwist::internal {

/// Sums over runs of how well one method did. RMSE and bound: 3-D, over all frames of all runs.
struct Score {
  size_t runs = 0, frames = 0;
  Eigen::Vector4d squared_error = Eigen::Vector4d::Zero();  // position, rotation, velocity, rate
  Eigen::Vector4d squared_bound = Eigen::Vector4d::Zero();  // traces of their covariances
  double nees_pose = 0, nees_twist = 0;                     // 6 degrees of freedom each
  double nees_of_middle = 0;  // 12 degrees of freedom, one frame a run: independent draws

  Score& operator+=(const Score& other);
};

/// The methods that are compared: batch; window at its lag; window at the frame's arrival. The
/// window's frames count from the one that first fills it: before, it does not know the noise.
struct RunScores {
  Score batch, lagged, current;
  RunScores& operator+=(const RunScores& other);
};

/// Estimates a run both ways and judges every frame by its truth.
Result<RunScores> ScoreRun(const SetUp& set_up, const EstimatorOptions& options,
                           const BenchRun& run);

/// Cells of the table: one row a method.
std::vector<std::string> ScoreHeader();
std::vector<std::string> ScoreCells(const std::string& flight, const std::string& method,
                                    const Score& score);

/// "NEES 12.1 over 200 runs, inside the 99 % band 11.1 to 12.9; RMSE / bound at most 1.01".
std::string Verdict(const Score& score);

}  // namespace tagtwist::internal
