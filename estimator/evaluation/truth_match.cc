#include "estimator/evaluation/truth_match.h"

#include <cmath>

#include "frontend/types/truth.h"

namespace tagtwist {

std::vector<TruthMatch> MatchTruth(const PoseSeries& series, const std::vector<TruthSample>& truth,
                                   double time_offset_s, double max_gap_s) {
  const int64_t offset_ns = std::llround(1e9 * time_offset_s);
  std::vector<TruthMatch> out;
  for (const PoseSample& sample : series) {
    if (const auto at = InterpolateTruth(truth, sample.t_ns + offset_ns, max_gap_s)) {
      out.push_back({sample, *at});
    }
  }
  return out;
}

}  // namespace tagtwist
