#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/evaluation/alignment.h"
#include "estimator/evaluation/evaluation.h"
#include "estimator/evaluation/truth_match.h"
#include "estimator/report/findings/findings.h"
#include "frontend/base/format_text.h"
#include "frontend/base/ratio_statistic.h"
#include "frontend/base/statistics/chi_square.h"
#include "frontend/base/units.h"
#include "frontend/types/nees.h"

namespace tagtwist::internal {
namespace {

// Errors of one frame.
struct FrameError {
  double t_s = 0;
  // Of the estimate less the truth; the twist's entries only with truth that has one.
  StateVector error = StateVector::Zero();
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();
  double nees = 0;           // of 12, or without a twist 6, degrees of freedom
  double position_nees = 0;  // of 3
};

struct Errors {
  int dof = 12;
  std::vector<FrameError> frames;
};

Errors ErrorsOf(const Estimate& estimate, const std::vector<TruthSample>& truth) {
  Errors out;
  constexpr double kMaxGapS = 0.1;
  const auto matches = AlignedMatches(EstimatedSeries(estimate.frames), truth, {}, kMaxGapS);
  for (const TruthMatch& m : matches) {
    if (!m.truth.twist) out.dof = 6;
  }
  for (const TruthMatch& m : matches) {
    FrameError frame;
    const Twist twist = out.dof == 12 ? *m.truth.twist : *m.estimate.twist;
    frame.t_s = ToSeconds(m.estimate.t_ns - estimate.frames.front().t_ns);
    const BodyState estimated{m.estimate.world_from_body, *m.estimate.twist};
    const BodyState true_state{m.truth.world_from_body, twist};
    frame.error = Difference(estimated, true_state);
    frame.v_world = m.estimate.twist->v_world;
    const StateCovariance& p = *m.estimate.covariance;
    const auto nees = out.dof == 12 ? Nees(true_state, estimated, p, kWholeState)
                                    : Nees(true_state, estimated, p, kPoseEntries);
    const auto position_nees = Nees(true_state, estimated, p, kPositionEntries);
    if (!nees || !position_nees) continue;
    frame.nees = *nees;
    frame.position_nees = *position_nees;
    out.frames.push_back(frame);
  }
  return out;
}

// A mean over frames, in blocks of a second.
template <typename Value>
RatioStatistic Mean(const Errors& errors, Value&& value_and_weight) {
  RatioStatistic out;
  double block_s = 0;
  for (const FrameError& frame : errors.frames) {
    if (frame.t_s - block_s >= 1) {
      out.CloseBlock();
      block_s = frame.t_s;
    }
    const auto [value, weight] = value_and_weight(frame);
    out.Add(value, weight);
  }
  out.CloseBlock();
  return out;
}

using Pair = std::pair<double, double>;

// A mean error that makes up half of the mean square.
void AddOffset(const Errors& errors, int first, double unit, const char* name,
               const char* unit_name, const char* advice, std::vector<Finding>* out) {
  Eigen::Vector3d mean, sigma;
  double squares = 0, score = 0;
  for (int i = 0; i < 3; ++i) {
    const RatioStatistic s =
        Mean(errors, [&](const FrameError& f) { return Pair(f.error(first + i), 1); });
    mean(i) = s.ratio();
    sigma(i) = std::sqrt(s.variance());
    score = std::max(score, std::abs(s.Score(0)));
    for (const FrameError& f : errors.frames) squares += f.error(first + i) * f.error(first + i);
  }
  const double share = mean.squaredNorm() * static_cast<double>(errors.frames.size()) / squares;
  if (!(score > SignificantScore(3) && share > 0.5)) return;
  mean *= unit;
  sigma *= unit;
  out->push_back({Format("%s is off by a constant (%.2f, %.2f, %.2f) %s (±%.2f): %.0f %% of its "
                         "mean squared error.",
                         name, mean.x(), mean.y(), mean.z(), unit_name, sigma.norm(), 100 * share),
                  advice});
}

// Position errors along the velocity.
void AddClock(const Errors& errors, std::vector<Finding>* out) {
  const RatioStatistic late_s = Mean(errors, [](const FrameError& f) {
    return Pair(f.v_world.dot(f.error.segment<3>(3)), f.v_world.squaredNorm());
  });
  double squares = 0, explained = 0;
  for (const FrameError& f : errors.frames) {
    squares += f.error.segment<3>(3).squaredNorm();
    explained += (late_s.ratio() * f.v_world).squaredNorm();
  }
  constexpr double kShare = 0.15;
  if (!(std::abs(late_s.Score(0)) > SignificantScore(1) && explained > kShare * squares)) return;
  out->push_back(
      {Format("The position's error goes with the velocity, as if truth's clock were about "
              "%.2g ms %s: %.0f %% of its mean square.",
              1e3 * std::abs(late_s.ratio()), late_s.ratio() > 0 ? "late" : "early",
              100 * explained / squares),
       "tagtwist_compare --time_offset estimate finds the offset and judges without it."});
}

void AddCovariance(const Errors& errors, std::vector<Finding>* out) {
  const RatioStatistic nees = Mean(errors, [](const FrameError& f) { return Pair(f.nees, 1); });
  // Large errors are anything but normal; the mean of their logarithms is never above log(dof)
  // where the covariance is right (Jensen).
  const RatioStatistic logarithm =
      Mean(errors, [](const FrameError& f) { return Pair(std::log(f.nees), 1); });
  const bool is_large = logarithm.Score(std::log(errors.dof)) > SignificantScore(2);
  const bool is_small = nees.Score(errors.dof) < -SignificantScore(2);
  const double per_dof = nees.ratio() / errors.dof;
  const double sigma = std::sqrt(nees.variance()) / errors.dof;
  const std::string facts =
      Format("NEES is %.2f (±%.2f) a degree of freedom, where 1 is right: ", per_dof, sigma);
  if (is_large && per_dof > 1.5) {
    out->push_back({facts + Format("errors are %.1f times as large as the covariances say.",
                                   std::sqrt(per_dof)),
                    "Offsets and clocks told above count in it; what is left is a wrong lens, map "
                    "or mount, which --calibrate finds against this truth, or truth's own noise."});
  } else if (is_small && per_dof < 0.5) {
    out->push_back({facts + Format("errors are %.1f times smaller than the covariances say.",
                                   1 / std::sqrt(per_dof)),
                    ""});
  }
}

// Positions that lie outside their covariance where most do not.
void AddOutliers(const Errors& errors, std::vector<Finding>* out) {
  const double most = ChiSquareQuantile(1 - 1e-6, 3);
  std::vector<double> t_s;
  std::vector<bool> flags;
  double worst_m = 0, worst_nees = 0;
  size_t count = 0;
  for (const FrameError& f : errors.frames) {
    t_s.push_back(f.t_s);
    flags.push_back(f.position_nees > most);
    if (!flags.back()) continue;
    ++count;
    worst_m = std::max(worst_m, f.error.segment<3>(3).norm());
    worst_nees = std::max(worst_nees, f.position_nees);
  }
  constexpr double kMostFrames = 0.2;  // beyond, it is no exception
  if (count == 0 || static_cast<double>(count) > kMostFrames * static_cast<double>(t_s.size())) {
    return;
  }
  out->push_back({"Position lies far from truth at " + StretchesText(t_s, flags) +
                      Format(": by up to %.1f mm, %.1f times its standard deviation.",
                             1e3 * worst_m, std::sqrt(worst_nees)),
                  "Look there at the errors, the tags in use and the truth."});
}

// However short truth is: where nothing else is told, and most frames that have it lie far beyond
// what their covariances may be off by.
void AddFarOff(const Errors& errors, std::vector<Finding>* out) {
  constexpr size_t kLeastFrames = 5;
  constexpr double kSigmas = 50;
  std::vector<double> off_m, sigmas;
  for (const FrameError& f : errors.frames) {
    off_m.push_back(f.error.segment<3>(3).norm());
    sigmas.push_back(std::sqrt(f.position_nees));
  }
  if (!out->empty() || off_m.size() < kLeastFrames) return;
  std::sort(sigmas.begin(), sigmas.end());
  if (!(sigmas[sigmas.size() / 4] > kSigmas)) return;
  std::sort(off_m.begin(), off_m.end());
  out->push_back({Format("Truth lies %.1f mm off in the median of the %zu frames that have it, "
                         "%.0f times the position's standard deviation.",
                         1e3 * off_m[off_m.size() / 2], off_m.size(), sigmas[sigmas.size() / 2]),
                  "It is too short to tell why: look at its clock, its world and its body."});
}

// Where nothing else is told, though chance is out of the question for many frames, however their
// errors go together: a fault that grows leaves few blocks to tell it from chance by.
void AddBeyondChance(const Errors& errors, std::vector<Finding>* out) {
  constexpr size_t kLeastFrames = 10;
  constexpr double kFar = 100, kOneIn = 5;  // 10 sigma, in a fifth of the frames
  std::vector<double> per_dof;
  for (const FrameError& f : errors.frames) per_dof.push_back(f.nees / errors.dof);
  const auto far = std::count_if(per_dof.begin(), per_dof.end(), [](double x) { return x > kFar; });
  if (!out->empty() || per_dof.size() < kLeastFrames ||
      kOneIn * static_cast<double>(far) < static_cast<double>(per_dof.size())) {
    return;
  }
  out->push_back({Format("In %td of %zu frames the errors are more than %.0f times as large as the "
                         "covariances say.",
                         far, per_dof.size(), std::sqrt(kFar)),
                  "Look how they go with time: truth's clock may run at another rate, its body may "
                  "slip, or lens, map and mount are not these."});
}

}  // namespace

std::vector<Finding> TruthFindings(const Estimate& estimate,
                                   const std::vector<TruthSample>& truth) {
  std::vector<Finding> out;
  const Errors errors = ErrorsOf(estimate, truth);
  if (errors.frames.empty()) return out;
  AddOffset(errors, 3, 1e3, "Position", "mm",
            "The mount (cam_from_body), the body's origin or truth's frame is another: "
            "tagtwist_compare --align handeye judges without it, --calibrate refines the mount.",
            &out);
  AddOffset(errors, 0, kDegreesPerRadian, "Attitude", "deg",
            "The mount's rotation, or the axes of truth's body, are others: tagtwist_compare "
            "--align handeye judges without it.",
            &out);
  AddClock(errors, &out);
  AddCovariance(errors, &out);
  AddOutliers(errors, &out);
  AddFarOff(errors, &out);
  AddBeyondChance(errors, &out);
  return out;
}

}  // namespace tagtwist::internal
