#include "estimator/solve/noise_learning.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "estimator/graph/linear_system.h"
#include "estimator/graph/noise_model.h"
#include "residuals/motion_residual.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

// Median of chi-square with 8 degrees of freedom, and its 0.9999 quantile.
constexpr double kMedianChi2Of8 = 7.344, kInlierChi2Of8 = 31.83;
// 0.99 quantile with 2 degrees of freedom, and the mean below it against the whole mean.
constexpr double kInlierChi2Of2 = 9.21, kInlierMeanOf2 = 0.9535;

// A track's errors are not white: it drifts, and lens and floor bend it like its neighbours. The
// views of a segment do not show that; the corners' spread does in part. So a track's sigma is
// never below the first of these, nor below that multiple of the corners'. Measured: trusting the
// 0.02 to 0.04 px that the views of rendered flights show, or on real frames anything near the
// corners' 0.45 px, made positions worse than no tracks at all.
constexpr double kLeastTrackSigmaPx = 0.1, kLeastTrackOverCorner = 2.0;

double Median(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

// Squared norm of a factor without its robust weight.
double SquaredNorm(const LinearFactor& linear) {
  return linear.residual.squaredNorm() / linear.weight;
}

bool InRange(const Factor& factor, const StateRange& range) {
  const int state = factor.blocks.front().index;
  return state >= range.first && state < range.last;
}

// States that see a tag or a track.
std::vector<bool> MeasuredStates(const Graph& graph) {
  std::vector<bool> out(graph.states.size(), false);
  for (const Factor& factor : graph.factors) {
    if (factor.kind == FactorKind::kTag || factor.kind == FactorKind::kTrack) {
      out[static_cast<size_t>(factor.blocks.front().index)] = true;
    }
  }
  return out;
}

std::vector<double> SquaredNormsOfTags(const Graph& graph) {
  std::vector<double> norms;
  Eigen::Matrix<double, 8, 1> residual;
  for (const Factor& factor : graph.factors) {
    if (factor.kind != FactorKind::kTag) continue;
    const auto& cost = static_cast<const TagReprojectionResidual&>(*factor.cost);
    const double* pose = graph.Parameters(factor.blocks.front());
    if (!cost.Linearize(pose, &residual, nullptr)) continue;
    norms.push_back(factor.information * residual.squaredNorm());
  }
  return norms;
}

// tr(J P J') of the first `rows` rows of a part of a motion factor between states k and k + 1.
double MotionLeverage(const LinearFactor& linear, const BlockBandedMatrix& p, int k,
                      const MotionResidual::Part& part, int rows) {
  Eigen::Matrix<double, 18, 18> joint;  // covariance of what enters
  Eigen::Matrix<double, 9, 18> jacobian;
  const auto& before = p.At(k, k);
  const auto& cross = p.At(k + 1, k);
  const auto& after = p.At(k + 1, k + 1);
  for (int i = 0; i < 3; ++i) {
    const int row = part.columns[static_cast<size_t>(i)];
    jacobian.middleCols<3>(3 * i) = linear.jacobian.block<9, 3>(part.first_row, row);
    jacobian.middleCols<3>(9 + 3 * i) =
        linear.jacobian.block<9, 3>(part.first_row, BlockBandedMatrix::kSize + row);
    for (int j = 0; j < 3; ++j) {
      const int column = part.columns[static_cast<size_t>(j)];
      joint.block<3, 3>(3 * i, 3 * j) = before.block<3, 3>(row, column);
      joint.block<3, 3>(9 + 3 * i, 3 * j) = cross.block<3, 3>(row, column);
      joint.block<3, 3>(3 * j, 9 + 3 * i) = cross.block<3, 3>(row, column).transpose();
      joint.block<3, 3>(9 + 3 * i, 9 + 3 * j) = after.block<3, 3>(row, column);
    }
  }
  const Eigen::Matrix<double, 9, 18> product = jacobian.lazyProduct(joint);
  return product.cwiseProduct(jacobian).topRows(rows).sum();
}

// Statistic of the nine rows of one part. Under white noise on acceleration the last three hold the
// idle acceleration and say nothing.
VarianceStatistic PartStatistic(const LinearFactor& linear, const BlockBandedMatrix& covariance,
                                int k, const MotionPrior& prior, const MotionResidual::Part& part) {
  const int rows = prior.on == WhiteNoiseOn::kJerk ? 9 : 6;
  return {linear.residual.segment(part.first_row, rows).squaredNorm() * prior.psd,
          rows - MotionLeverage(linear, covariance, k, part, rows)};
}

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
  return {on, on == WhiteNoiseOn::kJerk ? start_jerk : start_accel};
}

}  // namespace

VarianceStatistic& VarianceStatistic::operator+=(const VarianceStatistic& other) {
  sum += other.sum;
  dof += other.dof;
  return *this;
}

NoiseStatistics& NoiseStatistics::operator+=(const NoiseStatistics& other) {
  corner += other.corner;
  track += other.track;
  linear += other.linear;
  angular += other.angular;
  motion_s += other.motion_s;
  motions += other.motions;
  return *this;
}

NoiseStatistics NoiseStatistics::operator*(double factor) const {
  return {corner * factor,  track * factor,    linear * factor,
          angular * factor, motion_s * factor, motions * factor};
}

double TypicalTagScale(std::vector<double> squared_norms) {
  return squared_norms.empty() ? 1.0 : Median(&squared_norms) / kMedianChi2Of8;
}

double MostOfInlierTag(double typical_scale) { return kInlierChi2Of8 * typical_scale; }

// The tag's covariance is C + s^2 I, C its own. The score of the likelihood by s^2 is zero where
// s^2 = s^2 (e' R^-2 e) / tr(R^-1 - R^-1 J P J' R^-1), R = C + s^2 I: with C = 0 MacKay's fixed
// point, and with s^2 far below C a statistic of next to no degrees of freedom.
VarianceStatistic TagStatistic(const Eigen::Matrix<double, 8, 8>& whitener,
                               const Eigen::Matrix<double, 8, 1>& residual,
                               const Eigen::Matrix<double, 8, 6>& jacobian,
                               const Eigen::Matrix<double, 6, 6>& pose_covariance, double s2) {
  const Eigen::Matrix<double, 8, 8> scaled = std::sqrt(s2) * whitener.transpose();
  const Eigen::Matrix<double, 8, 6> scaled_jacobian = scaled.lazyProduct(jacobian);
  const double leverage =
      scaled_jacobian.lazyProduct(pose_covariance).cwiseProduct(scaled_jacobian).sum();
  return {s2 * scaled.lazyProduct(residual).squaredNorm(),
          std::max(0.0, scaled.squaredNorm() - leverage)};
}

void AddMotionStatistic(const LinearFactor& linear, const BlockBandedMatrix& covariance, int k,
                        const NoiseModel& noise, NoiseStatistics* out) {
  out->angular += PartStatistic(linear, covariance, k, noise.angular, MotionResidual::kAngular);
  out->linear += PartStatistic(linear, covariance, k, noise.linear, MotionResidual::kLinear);
}

NoiseStatistics ComputeNoiseStatistics(const Graph& graph, const BlockBandedMatrix& covariance,
                                       const NoiseModel& noise, const StateRange& range) {
  NoiseStatistics out;
  const double typical_scale = TypicalTagScale(SquaredNormsOfTags(graph));
  const std::vector<bool> measured = MeasuredStates(graph);
  LinearFactor linear;
  std::vector<int> views(graph.points.size(), 0);
  std::vector<double> sums(graph.points.size(), 0);
  for (const Factor& factor : graph.factors) {
    if (!InRange(factor, range) || !LinearizeFactor(graph, factor, &linear)) continue;
    const int k = factor.blocks.front().index;
    if (factor.kind == FactorKind::kMotion) {
      // Far from any measurement the prior says nothing of itself, and 9 - tr(J P J') is the
      // difference of equals.
      if (!measured[static_cast<size_t>(k)] && !measured[static_cast<size_t>(k + 1)]) continue;
      AddMotionStatistic(linear, covariance, k, noise, &out);
      out.motion_s += ToSeconds(graph.states[static_cast<size_t>(k + 1)].t_ns -
                                graph.states[static_cast<size_t>(k)].t_ns);
      ++out.motions;
    } else if (factor.kind == FactorKind::kTag) {
      if (SquaredNorm(linear) > MostOfInlierTag(typical_scale)) continue;
      const double plain = 1 / std::sqrt(linear.weight);
      out.corner += TagStatistic(
          std::sqrt(factor.information) *
              static_cast<const TagReprojectionResidual&>(*factor.cost).whitener(),
          plain * linear.residual, plain * linear.jacobian,
          covariance.At(k, k).topLeftCorner<6, 6>(), noise.corner_sigma_px * noise.corner_sigma_px);
    } else if (factor.kind == FactorKind::kTrack && SquaredNorm(linear) < kInlierChi2Of2) {
      const auto point = static_cast<size_t>(factor.blocks.back().index);
      ++views[point];
      sums[point] += SquaredNorm(linear);
    }
  }
  // The point takes two degrees of freedom; the poses, shared by many points, next to none.
  for (size_t i = 0; i < views.size(); ++i) {
    if (views[i] < 2) continue;
    out.track += {sums[i] * noise.track_sigma_px * noise.track_sigma_px,
                  kInlierMeanOf2 * (2.0 * views[i] - 2.0)};
  }
  return out;
}

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
  }
  if (!IsGiven(options.angular_accel_psd, options.angular_jerk_psd)) {
    const double least = LeastDensity(noise.angular.on, statistics);
    out.angular.psd = Updated(noise.angular.psd, statistics.angular, least_dof, least, 1e8);
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
