#include "estimator/solve/noise_extrapolation.h"

#include <algorithm>
#include <cmath>

#include "estimator/graph/noise_model.h"

namespace tagtwist::internal {
namespace {

// Just below what UpdateNoise lets a deviation's logarithm move by, ln(10) / 2.
constexpr double kLongestStepOfDeviation = 1.15;

}  // namespace

NoiseModel NoiseExtrapolation::Next(const NoiseModel& before, const NoiseModel& updated) {
  const auto logs = [](const NoiseModel& m) {
    return std::array<double, 4>{std::log(m.corner_sigma_px), std::log(m.track_sigma_px),
                                 std::log(m.linear.psd), std::log(m.angular.psd)};
  };
  const std::array<double, 4> from = logs(before), to = logs(updated);
  std::array<double, 4> step{}, extra{};
  for (size_t i = 0; i < 4; ++i) step[i] = to[i] - from[i];
  if (!last_step_) {
    for (size_t i = 0; i < 4; ++i) {
      if (step[i] * jump_[i] < 0 && std::abs(step[i]) > std::abs(jump_[i]) / 2) {
        went_too_far_[i] = true;
      }
    }
    last_step_ = step;
    return updated;
  }
  for (size_t i = 0; i < 4; ++i) {
    const double shrink = (*last_step_)[i] == 0 ? 0 : step[i] / (*last_step_)[i];
    // A deviation whose step was cut short (UpdateNoise) says little of where it would end: after a
    // jump from there that went too far another one would bring it back to where it came from.
    const bool is_deviation = i < 2;
    const bool is_cut_short = std::abs((*last_step_)[i]) > kLongestStepOfDeviation;
    if (is_deviation && is_cut_short && went_too_far_[i]) continue;
    // Only a steady geometric approach is carried on, and not beyond what can be believed. A
    // density that the data want to be zero falls by ever the same factor.
    constexpr double kSteady = 0.98;
    if (shrink > 0.1 && shrink < 1.1) {
      const double s = std::min(shrink, kSteady);
      extra[i] = std::clamp(step[i] * s / (1 - s), -2.0, 2.0);
    }
  }
  last_step_.reset();
  jump_ = extra;
  NoiseModel out = updated;
  out.corner_sigma_px *= std::exp(extra[0]);
  out.track_sigma_px *= std::exp(extra[1]);
  out.linear.psd *= std::exp(extra[2]);
  out.angular.psd *= std::exp(extra[3]);
  return out;
}

}  // namespace tagtwist::internal
