#pragma once
#include <vector>

#include "estimator/result/estimate.h"

namespace tagtwist {

/// What the window says when a frame comes in.
struct WindowOutput {
  FrameEstimate current;                // of the new frame, from all that came until now
  std::vector<double> reprojection_px;  // its corners' distances from their predictions
  std::vector<int> used_tags;           // ids of its tags that it was made with
  std::vector<FrameEstimate> lagged;    // of the frames that leave the window, smoothed, in order
};

}  // namespace tagtwist
