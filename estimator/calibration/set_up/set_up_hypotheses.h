#pragma once
#include <optional>
#include <vector>

#include "estimator/calibration/set_up/set_up_fit.h"
#include "frontend/base/fault.h"

namespace tagtwist::internal {

/// One mistake in a set-up: what of it is free, and what a fit says, if it says anything a person
/// would call a mistake: `least` times as much as a calibration may be off.
struct SetUpHypothesis {
  FreeChanges free;
  std::optional<Fault> (*words)(const SetUpFit&, const Camera&, double least,
                                double given_line_time_s);
};
const std::vector<SetUpHypothesis>& SetUpHypotheses();

}  // namespace tagtwist::internal
