#pragma once
#include <cstddef>
#include <map>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/result/estimate.h"
#include "estimator/result/tag_audit.h"
#include "estimator/start/doubled_tags.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// All frames of a batch, as they were seen and as they were solved.
struct SolvedFrames {
  const std::vector<FrameMeasurements>& measurements;
  const std::vector<GraphFrame>& frames;   // with final states, and the tags that were used
  const std::vector<int>& state_of_frame;  // -1: it had no state in the graph
};

/// Tags by the number of the frame that saw them.
using TagsByFrame = std::map<size_t, std::vector<TagDetection>>;

/// How well the tags agree with the solution, those in `refused` among them; their errors go to
/// `out`.
TagAudit AuditTags(const EstimatorSetup& setup, const SolvedFrames& solved,
                   const TagsByFrame& refused, Estimate* out);

/// Ways to leave out ids that two tags have: those that the solution shows elsewhere at one place,
/// in five frames; each of them alone, where they contradict one another; and, where they
/// contradict few others, those others. None where the solution was made with none of the first: a
/// tag that was moved takes part in nothing.
std::vector<DoubledTags> WaysWithoutTwins(const EstimatorSetup& setup, const SolvedFrames& solved,
                                          const DoubledTags& doubled);

/// The largest change of the body's mean velocity from one interval between frames with tags to the
/// next [m/s]: small on any flight, large where it changes to a twin's place.
double LargestJolt(const std::vector<FrameEstimate>& frames);

}  // namespace tagtwist::internal
