#pragma once
#include <string>
#include <vector>

#include "estimator/evaluation/pose_series.h"
#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// A trajectory that was read, named for people.
struct NamedSeries {
  std::string name;  // "run1: optimised", or the file's path
  PoseSeries series;
};

/// What a path given to tagtwist_compare holds.
struct ReadResults {
  std::vector<NamedSeries> series;
  std::vector<TruthSample> truth;  // that lies beside it, or none
  std::string truth_path;
};

/// Reads an output folder of tagtwist_estimate (states.csv, states_lagged.csv, closed_form.tum,
/// ground truth, covariances where they are), a states.csv with the covariance.csv beside it, or
/// any file of poses that ReadGroundTruth knows.
Result<ReadResults> ReadResultsAt(const std::string& path, const Limits& limits = {});

/// Files that ReadResultsAt may read, whether they are there or not.
std::vector<std::string> FilesReadAt(const std::string& path);

}  // namespace tagtwist::internal
