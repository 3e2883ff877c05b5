#include "estimator/motion/fast_vibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "frontend/base/statistics/quantile.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kLatest = 60, kLeast = 12;
// Third differences that are larger than most are of single events: hits, starts.
constexpr double kKept = 0.9;
// Of white noise of variance 1: the variance of a third difference, and its covariance with the
// next one.
constexpr double kOwn = 20, kNext = -15;

// Means over third differences, of a coordinate and whitened by the poses' covariances: squares,
// products with the one before, and squares of every second frame's, in excess of what noise makes
// of them.
struct Excess {
  double own = 0, next = 0, wide = 0;
  double plain = 0;        // as `own`, of a coordinate as it is
  double information = 0;  // of a coordinate, by the tags
  double sigma = 0;        // of `own`, by chance

  double TimesSigma() const { return sigma > 0 ? own / sigma : 0; }
  double Alike() const { return std::clamp(next / own, -1.0, 1.0); }
};

Excess ExcessOf(const std::deque<FastVibration::Thirds>& thirds, size_t part) {
  std::vector<double> squares;
  for (const auto& at : thirds) squares.push_back(at.parts[part].whitened.squaredNorm());
  const double most = Quantile(squares, kKept);
  Excess out;
  double n = 0, n_next = 0, n_wide = 0;
  for (size_t i = 0; i < thirds.size(); ++i) {
    if (squares[i] > most) continue;
    const auto third = [&](size_t back) { return thirds[i - back].parts[part]; };
    out.plain += third(0).plain.squaredNorm() / 3 - kOwn * third(0).noise;
    out.own += squares[i] / 3 - kOwn;
    out.information += third(0).information;
    ++n;
    const size_t behind = std::min(i, static_cast<size_t>(thirds[i].n_even));
    if (behind < 1 || squares[i - 1] > most) continue;
    out.next += third(0).whitened.dot(third(1).whitened) / 3 - kNext;
    ++n_next;
    if (behind < 3 || squares[i - 2] > most || squares[i - 3] > most) continue;
    const Eigen::Vector3d wide =
        third(0).whitened + 3 * (third(1).whitened + third(2).whitened) + third(3).whitened;
    out.wide += wide.squaredNorm() / 3 - kOwn;
    ++n_wide;
  }
  if (n_wide == 0) return {};
  out.plain /= n, out.own /= n, out.information /= n, out.next /= n_next, out.wide /= n_wide;
  out.sigma = kOwn * std::sqrt(2 / n);  // three coordinates, but of three frames' one is new
  return out;
}

// Whether frames show its motion: what a body does becomes less towards their rate.
bool IsShown(const Excess& excess) {
  constexpr double kMostAlike = 0.1, kMostWide = 5.5;
  return excess.Alike() > kMostAlike || excess.wide > kMostWide * excess.own;
}

// Variance of a coordinate by a sine that goes on by an angle of a from frame to frame: third
// differences have (2 - 2 cos a)^3 times that, and successive ones correlate by cos a. What chance
// may have hidden counts.
double VarianceBy(const Excess& excess, double alike) {
  const double own = (std::max(0.0, excess.own) + excess.sigma) / excess.information;
  return std::max(excess.plain, own) / std::pow(2 - 2 * alike, 3);
}

// Mean square of the angular rate [rad^2/s^2] of vibrations that frames of that interval cannot
// show and a body can have, their frequencies evenly spread in the logarithm; 0 where there is
// none.
double MeanSquareOfRate(double interval_s) {
  constexpr double kTwoPi = 6.28318530717958648, kFastestHz = 120, kLeastFrameHz = 8;
  const double slowest_hz = 0.5 / interval_s;
  if (slowest_hz > 0.9 * kFastestHz || 2 * slowest_hz < kLeastFrameHz) return 0;
  return kTwoPi * kTwoPi * (kFastestHz * kFastestHz - slowest_hz * slowest_hz) /
         (2 * std::log(kFastestHz / slowest_hz));
}

FastVibration::Third ThirdOf(const Eigen::Vector3d& difference, const Eigen::Matrix3d& noise) {
  const Eigen::LLT<Eigen::Matrix3d> llt(noise);
  return {difference, llt.matrixL().solve(difference), noise.trace() / 3,
          llt.solve(Eigen::Matrix3d::Identity()).trace() / 3};
}

}  // namespace

void FastVibration::Add(int64_t t_ns, const PoseMeasurement& pose) {
  constexpr double kEven = 0.2;  // of an interval
  const double interval_s = ToSeconds(t_ns - last_ns_);
  const bool is_even = std::abs(interval_s - interval_s_) < kEven * interval_s;
  n_even_ = is_even ? n_even_ + 1 : 0;
  const Pose& here = pose.world_from_body;
  const std::array<Eigen::Vector3d, 2> first = {
      here.translation() - last_.translation(),
      LogSo3(last_.rotation().conjugate() * here.rotation())};
  const std::array<Eigen::Vector3d, 2> second = {first[0] - first_[0], first[1] - first_[1]};
  if (n_even_ >= 2) {  // intervals like the one before
    thirds_.push_back({{ThirdOf(second[0] - second_[0], pose.position_covariance),
                        ThirdOf(second[1] - second_[1], pose.attitude_covariance)},
                       n_even_ - 2});
    if (thirds_.size() > kLatest) thirds_.pop_front();
    Judge(interval_s);
  }
  first_ = first, second_ = second;
  last_ns_ = t_ns, last_ = here, interval_s_ = interval_s;
}

void FastVibration::Judge(double interval_s) {
  constexpr double kClearly = 5;
  constexpr double kMostM = 0.01, kMostRad = 0.03;  // larger ones are slower
  variances_.setZero();
  const double square_of_rate = MeanSquareOfRate(interval_s);
  if (thirds_.size() < kLeast || square_of_rate == 0) return;
  const Excess linear = ExcessOf(thirds_, 0), angular = ExcessOf(thirds_, 1);
  // Both vibrate at once and at one frequency, told by the one that shows it better.
  const Excess& better = linear.TimesSigma() > angular.TimesSigma() ? linear : angular;
  if (better.TimesSigma() < kClearly || IsShown(better)) return;
  const double of_linear = VarianceBy(linear, better.Alike()),
               of_angular = VarianceBy(angular, better.Alike());
  if (of_linear > kMostM * kMostM || of_angular > kMostRad * kMostRad) return;
  variances_.segment<3>(6).setConstant(square_of_rate * of_linear);
  variances_.segment<3>(9).setConstant(square_of_rate * of_angular);
}

}  // namespace tagtwist::internal
