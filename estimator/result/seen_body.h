#pragma once
#include <vector>

#include "estimator/result/estimate.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// What is known of a body at one frame.
struct SeenBody {
  FrameEstimate state;                  // of the body in W
  std::vector<TagDetection> tags;       // of the body, as they were seen, by all cameras
  std::vector<int> used_tags;           // ids of those that the state was made with
  std::vector<double> reprojection_px;  // distances of their corners from where the state has them
};

}  // namespace tagtwist::internal
