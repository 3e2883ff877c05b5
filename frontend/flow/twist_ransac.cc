#include "frontend/flow/twist_ransac.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace tagtwist::internal {
namespace {

constexpr int kSampleSize = 3;

// Distinct indices below n >= kSampleSize. Drawn from raw bits: the standard's distributions differ
// between libraries.
std::vector<size_t> DrawSample(size_t n, std::mt19937_64* engine) {
  std::vector<size_t> sample;
  while (sample.size() < kSampleSize) {
    const size_t index = (*engine)() % n;
    if (std::find(sample.begin(), sample.end(), index) == sample.end()) sample.push_back(index);
  }
  return sample;
}

std::vector<size_t> FindInliers(const std::vector<FlowPoint>& flow, const CameraTwist& twist,
                                double threshold) {
  std::vector<size_t> inliers;
  for (size_t i = 0; i < flow.size(); ++i) {
    const Eigen::Vector2d error =
        InteractionMatrix(flow[i].point, flow[i].depth_m) * twist - flow[i].flow;
    if (error.norm() < threshold) inliers.push_back(i);
  }
  return inliers;
}

}  // namespace

int RansacIterations(double success, double inlier_ratio, int sample_size) {
  constexpr double kMost = 10000;
  const double iterations =
      std::log(1 - success) / std::log(1 - std::pow(inlier_ratio, sample_size));
  return static_cast<int>(std::clamp(std::floor(iterations), 1.0, kMost));
}

TwistRansacResult EstimateTwistRansac(const std::vector<FlowPoint>& flow,
                                      const TwistRansacOptions& options) {
  TwistRansacResult result;
  result.inlier_mask.assign(flow.size(), false);
  if (flow.size() < kSampleSize) return result;
  std::mt19937_64 engine(options.random_seed);
  const int most_iterations = RansacIterations(options.success, options.inlier_ratio, kSampleSize);
  std::vector<size_t> best;
  result.stop = RansacStop::kIterations;
  while (result.iterations < most_iterations && result.stop != RansacStop::kEnoughInliers) {
    ++result.iterations;
    const auto twist = SolveTwist(flow, DrawSample(flow.size(), &engine));
    if (!twist) continue;
    std::vector<size_t> inliers = FindInliers(flow, *twist, options.threshold);
    if (inliers.size() > best.size()) best = std::move(inliers);
    if (best.size() >= static_cast<size_t>(options.enough_inliers)) {
      result.stop = RansacStop::kEnoughInliers;
    }
  }
  // A sample always agrees with itself.
  if (best.size() <= kSampleSize) {
    best.resize(flow.size());
    std::iota(best.begin(), best.end(), size_t{0});
  }
  result.twist_of_cam_in_cam = SolveTwist(flow, best);
  if (!result.twist_of_cam_in_cam) {
    result.stop = RansacStop::kNoConsensus;
    return result;
  }
  result.n_inliers = static_cast<int>(best.size());
  for (const size_t i : best) result.inlier_mask[i] = true;
  return result;
}

}  // namespace tagtwist::internal
