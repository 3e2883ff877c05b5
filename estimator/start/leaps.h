#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"

namespace tagtwist::internal {

/// Whether a body could have gone from one pose to the other in dt_s: at less than 10 m/s and
/// 20 rad/s.
bool IsWithinReach(const Pose& from, const Pose& to, double dt_s);

/// Which frames with one tag alone have a pose, as well as its mirrored one, that no body could
/// have reached, by 6 sigma, from the frame with tags before nor left for the one after
/// (IsWithinReach), though it could have gone from one to the other: a wrong id, or a quad that is
/// no tag. Tags that agree with one another count as they are.
std::vector<bool> Leaps(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames);

/// Takes lone tags out of the few solved frames in which the body would be faster than that: a gap
/// leaves a solution the room to meet two phantoms in a row. A body that is often so fast is. True
/// where there were any.
bool DropBeyondReach(std::vector<GraphFrame>* frames);

/// Takes lone tags that fewer than three frames in a row show out of solved frames where the body
/// would have to go another way than it does elsewhere: further from the cubic between the nearest
/// frames that support one another than the body is in nine of ten stretches of such frames as
/// long, four times over, and than the tag may be off. The frames around that have no tags are put
/// on that cubic. True where there were any.
bool DropUnlikelyGlimpses(const EstimatorSetup& setup, std::vector<GraphFrame>* frames);
bool HasUnlikelyGlimpses(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames);

}  // namespace tagtwist::internal
