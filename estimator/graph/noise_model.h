#pragma once
#include <algorithm>
#include <array>
#include <utility>

#include "frontend/base/named_enum.h"
#include "residuals/motion_prior.h"

namespace tagtwist {

/// Where the noise comes from: what is not given is the default or was learned.
enum class NoiseSource { kDefault, kLearned, kGiven, kDefaultAndGiven, kLearnedAndGiven };
template <>
struct EnumNames<NoiseSource> {
  static constexpr std::array<std::pair<NoiseSource, const char*>, 5> kAll = {
      {{NoiseSource::kDefault, "default"},
       {NoiseSource::kLearned, "learned"},
       {NoiseSource::kGiven, "given"},
       {NoiseSource::kDefaultAndGiven, "default, given"},
       {NoiseSource::kLearnedAndGiven, "learned, given"}}};
};

/// Noise that the estimate was made with.
struct NoiseModel {
  double corner_sigma_px = 0.5;  // one corner coordinate, beyond a detection's own covariance
  double track_sigma_px = 0.3;   // one track coordinate
  MotionPrior linear{WhiteNoiseOn::kJerk, 30.0};    // [(m/s^3)^2/Hz] or [(m/s^2)^2/Hz]
  MotionPrior angular{WhiteNoiseOn::kJerk, 300.0};  // [(rad/s^3)^2/Hz] or [(rad/s^2)^2/Hz]
  NoiseSource source = NoiseSource::kDefault;
  bool corner_is_given = false;  // then a detection's own covariance does not count
  /// Above 0 the tags do not tell a body that turns from one that moves, which look alike at that
  /// distance: the densities are one, linear.psd = lever_m^2 angular.psd, where both are learned.
  double lever_m = 0;
};

namespace internal {

/// Where the noise has a lever, raises either density to what the other looks like there.
inline void TieDensities(NoiseModel* noise) {
  if (!(noise->lever_m > 0)) return;
  const double square_m2 = noise->lever_m * noise->lever_m;
  noise->linear.psd = std::max(noise->linear.psd, square_m2 * noise->angular.psd);
  noise->angular.psd = noise->linear.psd / square_m2;
  noise->linear.shake_s = noise->angular.shake_s = 0;
}

/// The prior of one part of a motion over an interval dt_s [s] that nothing leads over
/// (MotionScale::breaks): of the density under which it leaves 100 m, or 100 rad, open.
inline MotionPrior PriorOverBreak(const MotionPrior& prior, double dt_s) {
  constexpr double kInformation = 1e-4;
  const double root = RootInformation(WithDensity(prior, 1.0), dt_s)(0, 0);
  return WithDensity(prior, root * root / kInformation);
}

}  // namespace internal
}  // namespace tagtwist
