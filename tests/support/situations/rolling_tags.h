#pragma once
#include <functional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Tags as a global shutter saw them at the stamp become those of the set-up's rolling one: row v
/// is taken line_time_s * v after it. `pose_after`: world_from_body so many seconds after the
/// stamp.
void RollTags(const EstimatorSetup& setup, const std::function<Pose(double s)>& pose_after,
              std::vector<TagDetection>* tags);

}  // namespace tagtwist::internal
