#pragma once
#include <functional>
#include <vector>

#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal {

/// The course's camera, and two that look ahead and aside, each with a lens of its own.
SetUp RigOfThree();

/// What one of a rig's cameras sees of the map, at most three tags.
std::vector<TagDetection> SeenByCamera(const SetUp& set_up, int camera, const Pose& world_from_body,
                                       double sigma_px, unsigned seed);

/// Eight flights of that set-up by the estimator's own model, drawn by `draw` under their options:
/// what batch and window, at arrival and at the lag, say of their errors holds (NEES), and batch is
/// no further off than 1.2 of its sigmas.
void ExpectHonestEstimates(const SetUp& set_up,
                           const std::function<ExactModelFlight(const ExactModelOptions&)>& draw);

}  // namespace tagtwist::internal
