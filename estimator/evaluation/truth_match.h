#pragma once
#include <cstdint>
#include <vector>

#include "estimator/evaluation/pose_series.h"
#include "frontend/types/body_state.h"
#include "frontend/types/truth.h"

namespace tagtwist::internal {

/// An estimate and the truth that belongs to it.
struct TruthMatch {
  PoseSample estimate;
  TruthSample truth;
};

/// Pairs of one time, in order of time; the truth's clock is time_offset_s ahead. The denser of the
/// two is asked between its samples: every sample of the series that has truth at its stamp
/// (InterpolateTruth), or, where the truth's stamps are farther apart than the series', every truth
/// sample at which the series has a pose (SampleAt). A sparse truth says nothing between its
/// stamps.
std::vector<TruthMatch> MatchTruth(const PoseSeries& series, const std::vector<TruthSample>& truth,
                                   double time_offset_s, double max_gap_s);

}  // namespace tagtwist::internal
