#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"

namespace tagtwist::internal {

/// Distance of every accepted corner from its prediction [px], frame by frame.
std::vector<double> ReprojectionErrors(const EstimatorSetup& setup, const GraphFrame& frame);

}  // namespace tagtwist::internal
