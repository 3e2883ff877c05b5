#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "frontend/base/result.h"
#include "frontend/geometry/frame_pose.h"

namespace tagtwist::internal {

/// Where the solve starts: constant motion from a state over dt_s.
BodyState Predict(const BodyState& state, double dt_s);

/// The frame's pose as its tags say it, chosen among the minima that they leave open: the one
/// nearest in attitude to `expected`, where there is one. nullopt without a usable tag.
std::optional<Pose> ChoosePose(const FramePose& found, const Pose* expected);

/// Tags of a frame that agree on its pose.
std::vector<TagDetection> AgreeingTags(const std::vector<TagDetection>& tags,
                                       const FramePose& found);

/// Where the solve of a whole recording starts. Frames with tags: the pose that most tags agree on,
/// minima told apart by the likeliest path through all (LikeliestPath); other frames: between their
/// neighbours, the first and last ones at rest. Twists: the closed form's (RANSAC), or the
/// difference of neighbouring poses. Errors when no frame has a usable tag.
Result<std::vector<GraphFrame>> StartFrames(const EstimatorSetup& setup,
                                            const std::vector<FrameMeasurements>& measurements);

}  // namespace tagtwist::internal
