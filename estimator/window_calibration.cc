#include "estimator/window_calibration.h"

#include <cmath>

#include "estimator/linear_system.h"
#include "estimator/smoother.h"

namespace tagtwist {
namespace {

constexpr size_t kStretch = 75;  // frames
constexpr double kFade = 0.7;    // weight that a stretch keeps when the next one comes

// Of the square roots of the parts' variances, pooled over the axes.
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

void WindowCalibration::Add(const EstimatorSetup& setup, const NoiseModel& noise,
                            const std::vector<GraphFrame>& window) {
  if (passed_over_ > 0) {
    --passed_over_;
    return;
  }
  stretch_.push_back(window.front());
  if (stretch_.size() < kStretch) return;
  stretch_.insert(stretch_.end(), window.begin() + 1, window.end());
  Update(setup, noise, kStretch - 1);
  stretch_.clear();
  passed_over_ = kStretch;
}

void WindowCalibration::Update(const EstimatorSetup& setup, const NoiseModel& noise,
                               size_t leaving) {
  GraphInput input;
  input.frames = stretch_;
  const Graph graph = BuildGraph(setup, noise, input);
  const BlockBandedCholesky cholesky(Linearize(graph).hessian);
  if (!cholesky.ok()) return;
  const PriorCalibration calibration = CalibratePrior(graph);
  statistic_ = statistic_ * kFade;
  statistic_ += calibration.statistic;
  const BlockBandedMatrix covariance = cholesky.SelectedInverse();
  const auto calibrated = Calibrated(statistic_.Power(), calibration.of_prior, covariance);
  scale_ = Ratio(calibrated[leaving], BodyCovariance(covariance, static_cast<int>(leaving)));
}

}  // namespace tagtwist
