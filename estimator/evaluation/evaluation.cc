#include "estimator/evaluation/evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "estimator/evaluation/alignment.h"
#include "estimator/evaluation/error_bound.h"
#include "estimator/evaluation/truth_match.h"
#include "frontend/base/statistics/chi_square.h"
#include "frontend/types/nees.h"
#include "frontend/types/so3.h"

namespace tagtwist {

using namespace internal;
namespace {

// A frame farther from the wanted end of a step in time or along the path than this part of it does
// not end it.
constexpr double kStepTolerance = 0.1;

// Sums up pairs (i, second(i)); second returns the matches' size where there is no pair.
template <typename Second>
std::optional<RelativeError> RelativeErrors(const std::vector<TruthMatch>& matches,
                                            const Second& second) {
  std::vector<double> translation, rotation;
  for (size_t i = 0; i < matches.size(); ++i) {
    const size_t j = second(i);
    if (j >= matches.size()) continue;
    const auto motion = [](const Pose& a, const Pose& b) { return Inverse(a) * b; };
    const Pose truth = motion(matches[i].truth.world_from_body, matches[j].truth.world_from_body);
    const Pose estimate =
        motion(matches[i].estimate.world_from_body, matches[j].estimate.world_from_body);
    const Pose error = Inverse(truth) * estimate;
    translation.push_back(error.translation().norm());
    rotation.push_back(LogSo3(error.rotation()).norm());
  }
  if (translation.empty()) return std::nullopt;
  return RelativeError{Summarise(std::move(translation)), Summarise(std::move(rotation))};
}

// Index of the match nearest to t_i + step, if it is near enough and the matches reach that far.
size_t MatchAfter(const std::vector<TruthMatch>& matches, size_t i, double step_s) {
  const int64_t wanted = matches[i].estimate.t_ns + std::llround(1e9 * step_s);
  const auto at =
      std::lower_bound(matches.begin() + static_cast<std::ptrdiff_t>(i), matches.end(), wanted,
                       [](const TruthMatch& m, int64_t t) { return m.estimate.t_ns < t; });
  if (at == matches.end()) return matches.size();
  auto j = static_cast<size_t>(at - matches.begin());
  const int64_t over = matches[j].estimate.t_ns - wanted;
  if (j > i + 1 && over > wanted - matches[j - 1].estimate.t_ns) --j;
  const double miss_s = std::abs(ToSeconds(matches[j].estimate.t_ns - wanted));
  return miss_s <= kStepTolerance * step_s ? j : matches.size();
}

// Metres that the estimate has gone until each match.
std::vector<double> PathLengths(const std::vector<TruthMatch>& matches) {
  std::vector<double> out = {0};
  for (size_t i = 1; i < matches.size(); ++i) {
    const Pose &a = matches[i - 1].estimate.world_from_body,
               &b = matches[i].estimate.world_from_body;
    out.push_back(out.back() + (b.translation() - a.translation()).norm());
  }
  return out;
}

// Index of the later match whose way from match i is nearest to the step, if it is near enough.
size_t MatchAlong(const std::vector<double>& path_m, size_t i, double step_m) {
  const auto first = path_m.begin() + static_cast<std::ptrdiff_t>(i) + 1;
  if (first == path_m.end()) return path_m.size();
  const double wanted = path_m[i] + step_m;
  auto j = std::lower_bound(first, path_m.end(), wanted);
  if (j == path_m.end()) --j;
  if (j != first && wanted - *(j - 1) <= std::abs(*j - wanted)) --j;
  j = std::lower_bound(first, j, *j);  // the first of those that stand there
  return std::abs(*j - wanted) <= kStepTolerance * step_m ? static_cast<size_t>(j - path_m.begin())
                                                          : path_m.size();
}

void EvaluateTwist(const std::vector<TruthMatch>& matches, Accuracy* out) {
  std::vector<double> velocity, rate;
  for (const TruthMatch& m : matches) {
    if (!m.truth.twist || !m.estimate.twist) continue;
    velocity.push_back((m.estimate.twist->v_world - m.truth.twist->v_world).norm());
    rate.push_back((m.estimate.twist->omega_body - m.truth.twist->omega_body).norm());
  }
  if (velocity.empty()) return;
  out->velocity_mps = Summarise(std::move(velocity));
  out->rate_radps = Summarise(std::move(rate));
}

// A covariance that is not positive definite says nothing and is left out.
struct NeesSum {
  int dof = 0;
  size_t count = 0;
  double sum = 0;
  void Add(const std::optional<double>& nees) {
    if (!nees) return;
    sum += *nees;
    ++count;
  }
  std::optional<MeanNees> Mean() const {
    if (count == 0) return std::nullopt;
    const ChiSquareBand band = MeanChiSquareBand(dof, count);
    return MeanNees{dof, count, sum / static_cast<double>(count), band.low, band.high};
  }
};

void EvaluateNees(const std::vector<TruthMatch>& matches, Accuracy* out) {
  NeesSum whole{12}, pose{6}, twist{6};
  for (const TruthMatch& m : matches) {
    if (!m.estimate.covariance) continue;
    const StateCovariance& p = *m.estimate.covariance;
    const BodyState truth{m.truth.world_from_body, m.truth.twist.value_or(Twist())};
    const BodyState estimate{m.estimate.world_from_body, m.estimate.twist.value_or(Twist())};
    pose.Add(Nees(truth, estimate, p, kPoseEntries));
    if (!m.truth.twist || !m.estimate.twist) continue;
    whole.Add(Nees(truth, estimate, p, kWholeState));
    twist.Add(Nees(truth, estimate, p, kTwistEntries));
  }
  out->nees = whole.Mean();
  out->nees_pose = pose.Mean();
  out->nees_twist = twist.Mean();
}

std::optional<BoundRatio> CompareWithBound(const std::vector<TruthMatch>& matches,
                                           const Accuracy& accuracy) {
  std::vector<StateCovariance> covariances;
  for (const TruthMatch& m : matches) {
    if (!m.estimate.covariance) return std::nullopt;
    covariances.push_back(*m.estimate.covariance);
  }
  const ErrorBound bound = RmsBound(covariances);
  if (!(bound.position_m > 0) || !(bound.rotation_rad > 0)) return std::nullopt;
  BoundRatio out;
  out.position = accuracy.position_m.rmse / bound.position_m;
  out.rotation = accuracy.rotation_rad.rmse / bound.rotation_rad;
  if (accuracy.velocity_mps && bound.velocity_mps > 0 && bound.rate_radps > 0) {
    out.velocity = accuracy.velocity_mps->rmse / bound.velocity_mps;
    out.rate = accuracy.rate_radps->rmse / bound.rate_radps;
  }
  return out;
}

std::string SpanText(int64_t first_ns, int64_t last_ns) {
  char text[80];
  std::snprintf(text, sizeof text, "%.3f to %.3f s", ToSeconds(first_ns), ToSeconds(last_ns));
  return text;
}

Error NoOverlap(const PoseSeries& series, const std::vector<TruthSample>& truth) {
  if (series.empty()) return Error{"the trajectory has no pose"};
  if (truth.empty()) return Error{"the ground truth has no sample"};
  return Error{"no pose has ground truth at its time: the trajectory spans " +
               SpanText(series.front().t_ns, series.back().t_ns) + ", the ground truth " +
               SpanText(truth.front().t_ns, truth.back().t_ns)};
}

}  // namespace

ErrorStatistics Summarise(std::vector<double> norms) {
  ErrorStatistics out;
  out.count = norms.size();
  if (norms.empty()) return out;
  const double n = static_cast<double>(norms.size());
  std::sort(norms.begin(), norms.end());
  out.mean = std::accumulate(norms.begin(), norms.end(), 0.0) / n;
  out.rmse = std::sqrt(std::inner_product(norms.begin(), norms.end(), norms.begin(), 0.0) / n);
  out.median = 0.5 * (norms[(norms.size() - 1) / 2] + norms[norms.size() / 2]);
  out.max = norms.back();
  return out;
}

Result<Accuracy> Evaluate(const PoseSeries& series, const std::vector<TruthSample>& truth,
                          const EvaluationOptions& options) {
  if (series.empty() || truth.empty()) return NoOverlap(series, truth);
  const auto alignment = EstimateAlignment(series, truth, options.alignment);
  if (!alignment) return alignment.error();
  const auto matches = AlignedMatches(series, truth, *alignment, options.alignment.max_truth_gap_s);
  if (matches.empty()) return NoOverlap(series, truth);
  Accuracy out;
  out.frames = series.size();
  out.matched = matches.size();
  out.alignment = *alignment;
  std::vector<double> position, rotation;
  for (const TruthMatch& m : matches) {
    const Pose &estimate = m.estimate.world_from_body, &reference = m.truth.world_from_body;
    position.push_back((estimate.translation() - reference.translation()).norm());
    rotation.push_back(AngleBetween(reference, estimate));
  }
  out.position_m = Summarise(std::move(position));
  out.rotation_rad = Summarise(std::move(rotation));
  out.rpe_frames = RelativeErrors(matches, [&](size_t i) { return i + options.rpe_frames; });
  out.rpe_time = RelativeErrors(
      matches, [&](size_t i) { return MatchAfter(matches, i, options.rpe_seconds); });
  const std::vector<double> path_m = PathLengths(matches);
  out.rpe_distance =
      RelativeErrors(matches, [&](size_t i) { return MatchAlong(path_m, i, options.rpe_metres); });
  EvaluateTwist(matches, &out);
  EvaluateNees(matches, &out);
  out.rmse_over_bound = CompareWithBound(matches, out);
  return out;
}

}  // namespace tagtwist
