#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/track_segments.h"

namespace tagtwist::internal {

/// The state of each frame in the graph; -1 for frames that see nothing. Those need no state: the
/// trajectory between the others says all of them, and over a long gap a chain of states, tied by
/// nothing but the stiff motion prior, would be badly conditioned.
std::vector<int> StatesOfFrames(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames,
                                const std::vector<TrackSegment>& segments);

/// Frames with a state, taken from `frames`, and the segments counted in states.
GraphInput InputOfStates(const std::vector<int>& state_of_frame,
                         const std::vector<TrackSegment>& segments,
                         std::vector<GraphFrame>* frames);

}  // namespace tagtwist::internal
