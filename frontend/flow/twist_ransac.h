#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "frontend/flow/optical_flow.h"

namespace tagtwist::internal {

struct TwistRansacOptions {
  double threshold = 1.0;       // |A xi - flow| of an inlier [1/s], > 0
  double success = 0.99999999;  // seed Eq. 10
  double inlier_ratio = 0.8;    // seed Eq. 10
  int enough_inliers = 200;     // that many end the search
  uint64_t random_seed = 1;     // of the random draws
};

enum class RansacStop { kIterations, kEnoughInliers, kTooFewPoints, kNoConsensus };

struct TwistRansacResult {
  std::optional<CameraTwist> twist_of_cam_in_cam;  // least squares over the inliers
  std::vector<bool> inlier_mask;                   // one a point
  int n_inliers = 0;
  int iterations = 0;
  RansacStop stop = RansacStop::kTooFewPoints;
};

/// Iterations after which a sample free of outliers was drawn with probability `success` (seed
/// Eq. 10, rounded down as there: 25 with the seed's numbers and samples of three); at least 1.
int RansacIterations(double success, double inlier_ratio, int sample_size);

/// Twist by three-point RANSAC and a refit on all inliers (seed section "Part 2"); where no further
/// point agrees with any sample, by least squares over all points.
TwistRansacResult EstimateTwistRansac(const std::vector<FlowPoint>& flow,
                                      const TwistRansacOptions& options);

}  // namespace tagtwist::internal
