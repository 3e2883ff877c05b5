#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"

namespace tagtwist::internal {

/// Marks where a body was carried elsewhere (MotionScale::breaks): from one of three frames in a
/// row, tags of each of which agree, to the next three it lies further from where the velocities of
/// both sides lead than 200 m/s^2 and 2000 rad/s^2 take it. The states are where the frames' tags
/// say. A line that tells the person who runs it; nullopt without any.
std::optional<std::string> MarkBreaks(const EstimatorSetup& setup, std::vector<GraphFrame>* frames);

}  // namespace tagtwist::internal
