#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"

namespace tagtwist::internal {

/// Distance of every accepted corner from its prediction [px], frame by frame.
std::vector<double> ReprojectionErrors(const EstimatorSetup& setup, const GraphFrame& frame);
/// Of one tag, seen from there, added to `errors`.
void AddReprojectionErrors(const EstimatorSetup& setup, const Pose& world_from_body,
                           const TagDetection& tag, std::vector<double>* errors);

}  // namespace tagtwist::internal
