#pragma once
#include <optional>

#include "estimator/report/html/page.h"
#include "estimator/result/estimate.h"

namespace tagtwist::internal {

/// What a recording told of its IMU: whether it is in the estimate, and why not; gravity, clock,
/// axes, place, biases and noise, with standard deviations. nullopt where none was asked for.
std::optional<ReportSection> ImuSection(const Estimate& estimate);

}  // namespace tagtwist::internal
