#pragma once
#include <Eigen/Core>

namespace tagtwist {

/// What of a body's motion is white noise between two times: its acceleration (WNOA: the velocity
/// is a random walk) or its jerk (WNOJ: the acceleration is; smoother, as bodies with mass fly).
enum class WhiteNoiseOn { kAcceleration, kJerk };

/// Gaussian process prior of one part of the motion, three axes alike. Axis state: [x, dx/dt,
/// d2x/dt2]. With kAcceleration the third entry plays no part: it is 0 with unit variance at every
/// state, independent of all else, so that both priors have the same states.
struct MotionPrior {
  WhiteNoiseOn on = WhiteNoiseOn::kJerk;
  double psd = 1;  // power spectral density of the noise, > 0: [unit^2 / s^4 / Hz] or [.. s^6 / Hz]
  /// Of kAcceleration: the third entry is not idle but another factor's, and the prior says nothing
  /// of it: RootInformation has zeros there.
  bool leaves_third_free = false;
  /// Of kJerk: the acceleration has white noise of its own, too, of shake_s^2 times the density. A
  /// hand trembles and motors shake a body faster than its jerk, as a whole, lets on: the power
  /// spectral density of the acceleration is psd (1 / w^2 + shake_s^2).
  double shake_s = 0;
};

/// The same with another density.
inline MotionPrior WithDensity(MotionPrior prior, double psd) {
  prior.psd = psd;
  return prior;
}

/// Mean of an axis state dt_s later: [1 dt dt^2/2; 0 1 dt; 0 0 1], without the third column and row
/// for kAcceleration. dt_s may be negative.
Eigen::Matrix3d Transition(WhiteNoiseOn on, double dt_s);

/// Covariance that dt_s >= 0 of noise add to an axis state: psd [dt^5/20 dt^4/8 dt^3/6; dt^4/8
/// dt^3/3 dt^2/2; dt^3/6 dt^2/2 dt] for kJerk, psd [dt^3/3 dt^2/2; dt^2/2 dt] for kAcceleration
/// (Barfoot, State Estimation for Robotics, ch. 11; Tang, Yoon and Barfoot 2019 for WNOJ); kJerk
/// with a shake has shake_s^2 times the latter, too.
Eigen::Matrix3d ProcessCovariance(const MotionPrior& prior, double dt_s);

/// Upper triangular W with W'W = ProcessCovariance^-1; dt_s > 0.
Eigen::Matrix3d RootInformation(const MotionPrior& prior, double dt_s);

/// What part of the variance of each entry of RootInformation times the noise of dt_s > 0 the shake
/// makes; of independent entries, for the shake's covariance is diagonal there.
Eigen::Array3d ShareOfShake(const MotionPrior& prior, double dt_s);

}  // namespace tagtwist
