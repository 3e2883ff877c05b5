#include "estimator/graph/estimator_options.h"

#include <cmath>

#include "frontend/base/option_check.h"

namespace tagtwist {

using namespace internal;
namespace {

std::optional<std::string> CheckAtLeast(const char* key, int value, int least) {
  if (value >= least) return std::nullopt;
  return std::string(key) + ": expected >= " + std::to_string(least) + ", got " +
         std::to_string(value);
}

std::optional<std::string> CheckPositive(const char* key, const std::optional<double>& value) {
  if (!value || (*value > 0 && std::isfinite(*value))) return std::nullopt;
  return std::string(key) + ": expected > 0, got " + std::to_string(*value);
}

std::optional<std::string> CheckOneDensity(const char* key, const std::optional<double>& value,
                                           const char* other_key,
                                           const std::optional<double>& other) {
  if (!value || !other) return std::nullopt;
  return std::string(key) + ": expected not to be given together with " + other_key;
}

std::optional<std::string> CheckDensityOfPrior(const EstimatorOptions& options) {
  const bool accel = options.accel_psd || options.angular_accel_psd;
  const bool jerk = options.jerk_psd || options.angular_jerk_psd;
  if ((options.motion_prior == MotionPriorChoice::kAcceleration && jerk) ||
      (options.motion_prior == MotionPriorChoice::kJerk && accel)) {
    return std::string("motion_prior: expected one that fits the given density, got ") +
           NameOf(options.motion_prior);
  }
  return std::nullopt;
}

std::optional<std::string> CheckNotNegative(const char* name, const std::optional<double>& value) {
  return value ? CheckRange(name, *value, 0.0, 1e6) : std::nullopt;
}

}  // namespace

std::optional<std::string> EstimatorOptions::Problem() const {
  for (const auto& problem : {CheckPositive("corner_sigma_px", corner_sigma_px),
                              CheckPositive("track_sigma_px", track_sigma_px),
                              CheckPositive("accel_psd", accel_psd),
                              CheckPositive("angular_accel_psd", angular_accel_psd),
                              CheckPositive("jerk_psd", jerk_psd),
                              CheckPositive("angular_jerk_psd", angular_jerk_psd),
                              CheckOneDensity("jerk_psd", jerk_psd, "accel_psd", accel_psd),
                              CheckOneDensity("angular_jerk_psd", angular_jerk_psd,
                                              "angular_accel_psd", angular_accel_psd),
                              CheckDensityOfPrior(*this),
                              CheckAtLeast("max_tracks_per_frame", max_tracks_per_frame, 0),
                              CheckAtLeast("track_segment_frames", track_segment_frames, 2),
                              CheckPositive("robust_scale", robust_scale),
                              CheckAtLeast("window_frames", window_frames, 2),
                              CheckAtLeast("max_iterations", max_iterations, 1),
                              CheckAtLeast("window_iterations", window_iterations, 1),
                              CheckNotNegative("stamp_sigma_s", stamp_sigma_s),
                              CheckNotNegative("lens_field_sigma_px", lens_field_sigma_px),
                              CheckNotNegative("tag_sigma_m", tag_sigma_m),
                              CheckNotNegative("corner_bias_sigma_px", corner_bias_sigma_px),
                              CheckNotNegative("focal_sigma", focal_sigma)}) {
    if (problem) return problem;
  }
  if (window_frames < track_segment_frames) {
    return "window_frames: expected >= track_segment_frames (" +
           std::to_string(track_segment_frames) + "), got " + std::to_string(window_frames);
  }
  return std::nullopt;
}

}  // namespace tagtwist
