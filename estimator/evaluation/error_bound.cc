#include "estimator/evaluation/error_bound.h"

#include <cmath>

namespace tagtwist::internal {

ErrorBound RmsBound(const std::vector<StateCovariance>& covariances) {
  ErrorBound out;
  out.frames = covariances.size();
  if (covariances.empty()) return out;
  StateVector sum = StateVector::Zero();
  for (const StateCovariance& p : covariances) sum += p.diagonal();
  const auto rms = [&](int first) {
    return std::sqrt(sum.segment<3>(first).sum() / static_cast<double>(covariances.size()));
  };
  out.rotation_rad = rms(0);
  out.position_m = rms(3);
  out.velocity_mps = rms(6);
  out.rate_radps = rms(9);
  return out;
}

EstimateBounds BoundsOf(const Estimate& estimate) {
  const bool window = !estimate.lagged.empty();
  std::vector<StateCovariance> alone, posterior;
  for (const FrameEstimate& f : window ? estimate.lagged : estimate.frames) {
    if (f.status == FrameStatus::kNoFix) continue;
    posterior.push_back(f.covariance);
    if (!f.pose_bound) continue;
    alone.push_back(StateCovariance::Zero());
    alone.back().topLeftCorner<6, 6>() = *f.pose_bound;
  }
  return {RmsBound(alone), RmsBound(posterior),
          window ? ComparisonKey::kOptimisedLagged : ComparisonKey::kOptimised};
}

HalfNoiseGain GainOfHalfNoise(WhiteNoiseOn on) {
  // With n integrators between white noise and pose, the standard deviation of derivative k goes
  // with the corner noise to the power 1 - (2 k + 1) / (2 n).
  const double n = on == WhiteNoiseOn::kJerk ? 3 : 2;
  return {std::pow(2.0, 1 - 1 / (2 * n)), std::pow(2.0, 1 - 3 / (2 * n))};
}

}  // namespace tagtwist::internal
