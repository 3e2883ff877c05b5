#pragma once
#include <cstdint>
#include <optional>

#include "estimator/online/config.h"
#include "estimator/window/sliding_window.h"
#include "frontend/tags/guided_detector.h"

namespace tagtwist::internal {

/// What the window says of the pose at a coming stamp, as guided detection takes it; nullopt while
/// there is no state.
std::optional<PosePrediction> PredictPose(const SlidingWindow& window, int64_t t_ns);

/// The configuration with no more tracks than the graph takes (twice as many, for the RANSAC and
/// for those that lie on tags), and none while tags replace them.
Config ForOnlineUse(Config config);

}  // namespace tagtwist::internal
