#include "estimator/solve/noise_learning.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "estimator/graph/noise_model.h"
#include "residuals/motion_prior.h"

namespace tagtwist::internal {
namespace {

// A track's errors are not white: it drifts, and lens and floor bend it like its neighbours. The
// views of a segment do not show that; the corners' spread does in part. So a track's sigma is
// never below the first of these, nor below that multiple of the corners'. Measured: trusting the
// 0.02 to 0.04 px that the views of rendered flights show, or on real frames anything near the
// corners' 0.45 px, made positions worse than no tracks at all.
constexpr double kLeastTrackSigmaPx = 0.1, kLeastTrackOverCorner = 2.0;

// The least density: below it the prior's information from one state to the next would drown the
// measurements' in rounding.
double LeastDensity(WhiteNoiseOn on, const NoiseStatistics& statistics) {
  constexpr double kMostInformation = 1e18;  // corners may tell 1e7 / m^2
  if (!(statistics.motions > 0)) return 1e-8;
  const double root = RootInformation({on, 1.0}, statistics.motion_s / statistics.motions)(0, 0);
  return root * root / kMostInformation;
}

// New value of a variance. Data that say less of it than least_dof keep it: zero would claim what
// they do not show. Where `low` is above `high`, as the least density is of states microseconds
// apart, it rules.
double Updated(double variance, const VarianceStatistic& statistic, double least_dof, double low,
               double high) {
  if (!(statistic.dof >= least_dof)) return variance;
  const double ratio = std::clamp(statistic.sum / statistic.dof / variance, 0.1, 10.0);
  return std::clamp(variance * ratio, low, std::max(low, high));
}

// The shake that the statistics say. Below a tenth of the time from one state to the next it shows
// too little to grow from; where no state sees several tags it is taken for that. Starts, stops and
// other changes of the density look like shakes of any size as long as one density stands for all;
// a hand's tremor, at 8 to 12 Hz, has up to two hundredths of a second.
double UpdatedShake(const MotionPrior& prior, const ShakeStatistic& statistic, double dt_s) {
  constexpr double kLeast = 0.1, kMostS = 0.02;
  if (prior.on != WhiteNoiseOn::kJerk || !(prior.shake_s > 0)) return 0;
  if (!(dt_s > 0)) return prior.shake_s;
  const double least_s = std::min(kLeast * dt_s, kMostS);
  if (!(statistic.rest.dof > 0)) return least_s;
  // Few degrees of freedom say little: one more that holds by itself.
  const auto ratio = [](const VarianceStatistic& of) { return (1 + of.sum) / (1 + of.dof); };
  const double by = std::clamp(ratio(statistic.shake) / ratio(statistic.rest), 0.1, 10.0);
  return std::clamp(prior.shake_s * std::sqrt(by), least_s, kMostS);
}

bool IsGiven(const std::optional<double>& accel, const std::optional<double>& jerk) {
  return accel || jerk;
}

// `open`: where the noise comes from that is not given.
NoiseSource Source(const EstimatorOptions& options, NoiseSource open) {
  const int given = (options.corner_sigma_px ? 1 : 0) + (options.track_sigma_px ? 1 : 0) +
                    (IsGiven(options.accel_psd, options.jerk_psd) ? 1 : 0) +
                    (IsGiven(options.angular_accel_psd, options.angular_jerk_psd) ? 1 : 0);
  if (given == 4) return NoiseSource::kGiven;
  if (given == 0) return open;
  return open == NoiseSource::kLearned ? NoiseSource::kLearnedAndGiven
                                       : NoiseSource::kDefaultAndGiven;
}

// One part's prior as the options say it; `start` holds the densities to begin with.
MotionPrior InitialPrior(MotionPriorChoice choice, const std::optional<double>& accel,
                         const std::optional<double>& jerk, WhiteNoiseOn open, double start_accel,
                         double start_jerk) {
  if (accel) return {WhiteNoiseOn::kAcceleration, *accel};
  if (jerk) return {WhiteNoiseOn::kJerk, *jerk};
  WhiteNoiseOn on = open;
  if (choice == MotionPriorChoice::kAcceleration) on = WhiteNoiseOn::kAcceleration;
  if (choice == MotionPriorChoice::kJerk) on = WhiteNoiseOn::kJerk;
  MotionPrior out{on, on == WhiteNoiseOn::kJerk ? start_jerk : start_accel};
  constexpr double kStartShakeS = 0.001;
  if (on == WhiteNoiseOn::kJerk && choice == MotionPriorChoice::kAuto) out.shake_s = kStartShakeS;
  return out;
}

}  // namespace

bool MotionPriorIsOpen(const EstimatorOptions& options) {
  return options.motion_prior == MotionPriorChoice::kAuto && MotionIsLearned(options);
}

bool MotionIsLearned(const EstimatorOptions& options) {
  return !IsGiven(options.accel_psd, options.jerk_psd) &&
         !IsGiven(options.angular_accel_psd, options.angular_jerk_psd);
}

bool AnyNoiseIsOpen(const EstimatorOptions& options) {
  return !options.corner_sigma_px || !IsGiven(options.accel_psd, options.jerk_psd) ||
         !IsGiven(options.angular_accel_psd, options.angular_jerk_psd);
}

NoiseModel InitialNoise(const EstimatorOptions& options, WhiteNoiseOn open) {
  NoiseModel noise;
  noise.corner_sigma_px = options.corner_sigma_px.value_or(noise.corner_sigma_px);
  noise.track_sigma_px = options.track_sigma_px.value_or(noise.track_sigma_px);
  noise.linear =
      InitialPrior(options.motion_prior, options.accel_psd, options.jerk_psd, open, 1.0, 30.0);
  noise.angular = InitialPrior(options.motion_prior, options.angular_accel_psd,
                               options.angular_jerk_psd, open, 10.0, 300.0);
  noise.source = Source(options, NoiseSource::kDefault);
  noise.corner_is_given = options.corner_sigma_px.has_value();
  return noise;
}

NoiseModel UpdateNoise(const NoiseModel& noise, const NoiseStatistics& statistics,
                       const EstimatorOptions& options, double least_dof) {
  const auto square = [](double x) { return x * x; };
  const double dt_s = statistics.motions > 0 ? statistics.motion_s / statistics.motions : 0;
  NoiseModel out = noise;
  if (!options.corner_sigma_px) {
    out.corner_sigma_px = std::sqrt(Updated(square(noise.corner_sigma_px), statistics.corner,
                                            least_dof, square(1e-4), square(10.0)));
  }
  if (!options.track_sigma_px) {
    const double least = std::max(kLeastTrackSigmaPx, kLeastTrackOverCorner * out.corner_sigma_px);
    out.track_sigma_px = std::sqrt(Updated(square(noise.track_sigma_px), statistics.track,
                                           least_dof, square(least), square(20.0)));
  }
  if (!IsGiven(options.accel_psd, options.jerk_psd)) {
    const double least = LeastDensity(noise.linear.on, statistics);
    out.linear.psd = Updated(noise.linear.psd, statistics.linear, least_dof, least, 1e7);
    out.linear.shake_s = UpdatedShake(noise.linear, statistics.linear_shake, dt_s);
  }
  if (!IsGiven(options.angular_accel_psd, options.angular_jerk_psd)) {
    const double least = LeastDensity(noise.angular.on, statistics);
    out.angular.psd = Updated(noise.angular.psd, statistics.angular, least_dof, least, 1e8);
    out.angular.shake_s = UpdatedShake(noise.angular, statistics.angular_shake, dt_s);
  }
  if (MotionIsLearned(options)) TieDensities(&out);
  out.source = Source(options, NoiseSource::kLearned);
  return out;
}

double NoiseChange(const NoiseModel& a, const NoiseModel& b) {
  return std::max({std::abs(std::log(a.corner_sigma_px / b.corner_sigma_px)),
                   std::abs(std::log(a.track_sigma_px / b.track_sigma_px)),
                   0.5 * std::abs(std::log(a.linear.psd / b.linear.psd)),
                   0.5 * std::abs(std::log(a.angular.psd / b.angular.psd))});
}

}  // namespace tagtwist::internal
