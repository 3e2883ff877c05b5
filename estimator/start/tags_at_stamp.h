#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Corners of a rolling shutter's frame as they would be had the whole image been taken at its
/// stamp: each moved by the difference between its projections from the body's pose at the stamp
/// and line_time_s * v later, v its row, the body carried on by its twist. What the twist is off by
/// stays in the corners: 1 cm/s over 10 ms is 0.1 mm. Tags that the map lacks, and corners behind
/// the camera, stay as they are.
std::vector<TagDetection> TagsAsOfStamp(const EstimatorSetup& setup, const BodyState& at_stamp,
                                        std::vector<TagDetection> tags);

}  // namespace tagtwist::internal
