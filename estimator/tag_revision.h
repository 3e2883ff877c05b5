#pragma once
#include <vector>

#include "estimator/graph_builder.h"

namespace tagtwist {

/// True when every corner lies within five standard deviations of its prediction from the state.
bool AgreesWith(const EstimatorSetup& setup, const NoiseModel& noise, const BodyState& state,
                const TagDetection& tag);

/// Chooses anew which tags a solution is made with: leaves out those that it contradicts, and
/// wholly those that most of the frames that show them do without. With `readmit` it takes in again
/// what the seeds left out and the solution agrees with. `seen`: all tags of each frame; `frames`:
/// states of the solution with the tags it was made with. True when anything changed.
bool ReviseTags(const EstimatorSetup& setup, const NoiseModel& noise, const Graph& graph,
                const std::vector<const std::vector<TagDetection>*>& seen, bool readmit,
                std::vector<GraphFrame>* frames);

}  // namespace tagtwist
