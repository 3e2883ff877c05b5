#include "estimator/window/window_power.h"

#include <cmath>

#include "estimator/graph/noise_model.h"

namespace tagtwist::internal {
namespace {

// Frames of a stretch, and between two: the few that do the work stay below one in a hundred.
constexpr size_t kStretch = 75, kBetween = 450;
constexpr double kStretchFade = 0.7;  // weight that a stretch keeps when the next one comes

// Ratio of the square roots of the parts' variances, pooled over the axes.
StateVector Ratio(const StateCovariance& calibrated, const StateCovariance& covariance) {
  StateVector out;
  for (int part = 0; part < 12; part += 3) {
    const double of_part = calibrated.diagonal().segment<3>(part).sum();
    out.segment<3>(part).setConstant(
        std::sqrt(of_part / covariance.diagonal().segment<3>(part).sum()));
  }
  return out;
}

}  // namespace

void WindowPower::Add(const EstimatorSetup& setup, const NoiseModel& noise,
                      const std::vector<GraphFrame>& window) {
  if (finder_) {
    finder_->Step();
    if (finder_->done()) Finish();
  }
  if (passed_over_ > 0) {
    --passed_over_;
    return;
  }
  stretch_.push_back(window.front());
  if (stretch_.size() < kStretch) return;
  stretch_.insert(stretch_.end(), window.begin() + 1, window.end());
  GraphInput input;
  input.frames = std::move(stretch_);
  finder_.emplace(BuildGraph(setup, noise, input));
  stretch_.clear();
  passed_over_ = kBetween;
}

void WindowPower::Finish() {
  const PriorPower& prior = finder_->result();
  if (!prior.covariances.empty()) {
    constexpr size_t kLeaving = kStretch - 1;  // it left when the stretch was full
    statistic_ = statistic_ * kStretchFade;
    statistic_ += prior.statistic;
    const auto calibrated = WithPriorPower(statistic_.Power(), prior);
    scale_ = Ratio(calibrated[kLeaving], prior.covariances[kLeaving]);
  }
  finder_.reset();
}

}  // namespace tagtwist::internal
