#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/evaluation/pose_series.h"
#include "frontend/base/fault.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// The plain sign of a mistake in the ground truth, or in what connects it to the estimate: another
/// unit of length (1000:1), a map or a truth that is larger by a factor, axes exchanged (y up) or a
/// world turned against ours, quaternions with w first or of the inverse, a clock apart by up to
/// three seconds, a mount that is inverted. Each must explain nearly all of an error that no noise
/// has; nullopt otherwise. `max_gap_s`: as in InterpolateTruth.
std::optional<Fault> FindTruthFault(const PoseSeries& estimate,
                                    const std::vector<TruthSample>& truth,
                                    const Pose& cam_from_body, double max_gap_s);

}  // namespace tagtwist::internal
