#pragma once
#include <vector>

#include "estimator/evaluation/alignment_types.h"
#include "estimator/evaluation/pose_series.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A hand-eye alignment by the calibration's own solver (solver.h): its mount is
/// body_from_marker and its camera the body, whose poses are known; world and clock are the same.
/// Robust, each kind of misfit weighed by its own size, which is learned with how long it lasts;
/// so the sigmas hold for what the estimate and the ground truth err by together. Of the starts the
/// one whose optimum fits best. Directions that the motion does not show keep the prior's sigma:
/// 10 m and 3 rad. An error when fewer than three poses have truth at hand.
Result<Alignment> AlignHandEye(const PoseSeries& series, const std::vector<TruthSample>& truth,
                               const std::vector<Alignment>& starts,
                               const AlignmentOptions& options);

}  // namespace tagtwist::internal
