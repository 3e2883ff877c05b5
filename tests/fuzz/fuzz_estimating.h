#pragma once
#include <vector>

#include "estimator/graph/estimator_options.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"
#include "tests/fuzz/fuzz_bytes.h"

namespace tagtwist::internal {

/// The course's camera and mat.
const SetUp& CourseSetUpOnce();
/// Any in range, and some that are not: see EstimatorOptions::Problem.
EstimatorOptions TakeOptions(FuzzBytes* in);
/// Of its corners: up to 100 px^2 each, with what is common to them. nullopt: it has none.
OptionalApart<Eigen::Matrix<double, 8, 8>> TakeCovariance(FuzzBytes* in);

/// Batch and window over frames: no state without a number, every covariance positive, every
/// refusal told; else throws Broken. True where one of the two estimated them.
bool EstimatesSoundly(const EstimatorOptions& options,
                      const std::vector<FrameMeasurements>& frames);

}  // namespace tagtwist::internal
