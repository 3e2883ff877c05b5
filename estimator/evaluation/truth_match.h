#pragma once
#include <cstdint>
#include <vector>

#include "estimator/evaluation/pose_series.h"
#include "frontend/types/body_state.h"
#include "frontend/types/truth.h"

namespace tagtwist {

/// An estimate and the truth that belongs to it.
struct TruthMatch {
  PoseSample estimate;
  TruthSample truth;
};

/// Every sample that has truth at its stamp + time_offset_s, in order of time.
std::vector<TruthMatch> MatchTruth(const PoseSeries& series, const std::vector<TruthSample>& truth,
                                   double time_offset_s, double max_gap_s);

}  // namespace tagtwist
