#pragma once
#include <functional>

#include "frontend/types/rig.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal {

/// Eight flights of that set-up by the estimator's own model, drawn by `draw` under their options:
/// what batch and window, at arrival and at the lag, say of their errors holds (NEES), and batch is
/// no further off than 1.2 of its sigmas.
void ExpectHonestEstimates(const SetUp& set_up,
                           const std::function<ExactModelFlight(const ExactModelOptions&)>& draw);

}  // namespace tagtwist::internal
