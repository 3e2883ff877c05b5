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
    const auto log = [](double shake_s) { return shake_s > 0 ? std::log(shake_s) : 0; };
    return Logs{std::log(m.corner_sigma_px), std::log(m.track_sigma_px), std::log(m.linear.psd),
                std::log(m.angular.psd),     log(m.linear.shake_s),      log(m.angular.shake_s)};
  };
  const Logs from = logs(before), to = logs(updated);
  Logs step{}, extra{};
  for (size_t i = 0; i < step.size(); ++i) step[i] = to[i] - from[i];
  if (!last_step_) {
    for (size_t i = 0; i < step.size(); ++i) {
      if (step[i] * jump_[i] < 0 && std::abs(step[i]) > std::abs(jump_[i]) / 2) {
        went_too_far_[i] = true;
      }
    }
    last_step_ = step;
    return updated;
  }
  for (size_t i = 0; i < step.size(); ++i) {
    const double shrink = (*last_step_)[i] == 0 ? 0 : step[i] / (*last_step_)[i];
    // A deviation whose step was cut short (UpdateNoise) says little of where it would end: after a
    // jump from there that went too far another one would bring it back to where it came from.
    const bool is_deviation = i != 2 && i != 3;  // but the densities
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
  out.linear.shake_s *= std::exp(extra[4]);
  out.angular.shake_s *= std::exp(extra[5]);
  return out;
}

}  // namespace tagtwist::internal
