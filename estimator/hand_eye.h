#pragma once
#include <vector>

#include "estimator/alignment.h"

namespace tagtwist {

/// Refines an alignment so that the sum over all matches of |position misfit|^2 +
/// (metres_per_radian |rotation misfit|)^2 is least: Levenberg-Marquardt over truth_from_world,
/// body_from_marker and, when options.estimate_time_offset, the time offset. Misfits are
///   A (p + R l) + a - p_truth  and  Log(R_truth' A R M),
/// A, a = truth_from_world; R, p = world_from_body; M, l = body_from_marker.
struct HandEyeResult {
  Alignment alignment;
  double cost = 0;  // mean squared misfit of a match [m^2]
};
HandEyeResult RefineHandEye(const PoseSeries& series, const std::vector<TruthSample>& truth,
                            const Alignment& initial, const AlignmentOptions& options);

}  // namespace tagtwist
