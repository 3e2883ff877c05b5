#pragma once
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estimator/result/estimate.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {

/// What is the same in all frames of a run that is published, and how its parts are called.
struct PublishedRun {
  SetUp set_up;         // of one camera; its name is the rig's
  std::string dataset;  // as the user named it
  std::string body = "body", world = "world";
};

/// A frame as it is published, once its state is known.
struct PublishedFrame {
  FrameEstimate state;
  std::vector<TagDetection> tags;  // as they were seen
  std::vector<int> used_tags;      // ids of those that the state was made with
  double reprojection_px = 0;      // median distance of their corners from where the state has them
  double latency_ms = 0;           // from its stamp to its state; 0 where the run is not live
  size_t frames_dropped = 0;       // that came while others waited, so far
  cv::Mat image;                   // 8-bit gray; empty: none
};

/// Several threads read it; none changes it.
using FramePtr = std::shared_ptr<const PublishedFrame>;

}  // namespace tagtwist::internal
