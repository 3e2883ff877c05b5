#include "estimator/evaluation/truth_match.h"

#include <algorithm>
#include <cmath>

#include "frontend/base/statistics/quantile.h"
#include "frontend/types/truth.h"

namespace tagtwist::internal {
namespace {

// Typical time between samples [s]; 0 where there are fewer than two.
template <typename Samples>
double Step(const Samples& samples) {
  std::vector<double> steps_s;
  for (size_t i = 1; i < samples.size(); ++i) {
    steps_s.push_back(ToSeconds(samples[i].t_ns - samples[i - 1].t_ns));
  }
  return steps_s.empty() ? 0 : Quantile(std::move(steps_s), 0.5);
}

// Between samples that are a little farther apart than usual the series still counts.
std::vector<TruthMatch> AtStampsOfTruth(const PoseSeries& series, double series_step_s,
                                        const std::vector<TruthSample>& truth, int64_t offset_ns,
                                        double max_gap_s) {
  const double gap_s = std::max(max_gap_s, 1.5 * series_step_s);
  std::vector<TruthMatch> out;
  for (const TruthSample& sample : truth) {
    if (auto at = SampleAt(series, sample.t_ns - offset_ns, gap_s)) {
      out.push_back({std::move(*at), sample});
    }
  }
  return out;
}

}  // namespace

std::vector<TruthMatch> MatchTruth(const PoseSeries& series, const std::vector<TruthSample>& truth,
                                   double time_offset_s, double max_gap_s) {
  constexpr double kSparser = 1.2;
  const int64_t offset_ns = std::llround(1e9 * time_offset_s);
  const double series_step_s = Step(series);
  if (series_step_s > 0 && Step(truth) > kSparser * series_step_s) {
    return AtStampsOfTruth(series, series_step_s, truth, offset_ns, max_gap_s);
  }
  std::vector<TruthMatch> out;
  for (const PoseSample& sample : series) {
    if (const auto at = InterpolateTruth(truth, sample.t_ns + offset_ns, max_gap_s)) {
      out.push_back({sample, *at});
    }
  }
  return out;
}

}  // namespace tagtwist::internal
