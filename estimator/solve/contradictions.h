#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/quadratic_chain.h"

namespace tagtwist::internal {

/// A measurement whose Huber weight is below this contradicts the rest.
inline constexpr double kContradictedWeight = 0.6;

/// Tags that the solution contradicts, as state and index in its frame.
struct TagRef {
  int state = 0, tag = 0;
};
std::vector<TagRef> ContradictedTags(const Graph& graph);
/// The same of a chain, as its factors were when last linearised.
std::vector<TagRef> ContradictedTags(const QuadraticChain& chain);
/// Takes those tags out of their frames.
void DropTags(std::vector<TagRef> tags, std::vector<GraphFrame>* frames);

/// Which of n segments the solution contradicts in some view: a moving object, a slipped track.
std::vector<bool> ContradictedSegments(const Graph& graph, size_t n);

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

}  // namespace tagtwist::internal
