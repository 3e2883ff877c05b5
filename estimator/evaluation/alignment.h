#pragma once
#include <vector>

#include "estimator/evaluation/alignment_types.h"
#include "estimator/evaluation/pose_series.h"
#include "estimator/evaluation/truth_match.h"
#include "frontend/base/result.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// Rigid motion a of least squares |truth - a * estimate| over positions: Umeyama (1991) without
/// scale. At least one match; where the positions leave the rotation open (all in one point or on
/// one line) the result is one of the best.
Pose AlignPositions(const std::vector<TruthMatch>& matches);

/// The alignment that the options ask for. An error when fewer than three poses have truth.
Result<Alignment> EstimateAlignment(const PoseSeries& series, const std::vector<TruthSample>& truth,
                                    const AlignmentOptions& options);

/// Estimates brought into the truth's frames, each with its truth.
std::vector<TruthMatch> AlignedMatches(const PoseSeries& series,
                                       const std::vector<TruthSample>& truth,
                                       const Alignment& alignment, double max_truth_gap_s);

}  // namespace tagtwist::internal
