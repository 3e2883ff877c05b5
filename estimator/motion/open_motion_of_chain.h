#pragma once
#include <vector>

#include "estimator/motion/open_intervals.h"
#include "frontend/base/for_ranges.h"

namespace tagtwist::internal {

/// Adds to the covariances of all states of a chain what they lack because it is open how lively
/// the motion was over each interval. Nothing where tracks tie states that are no neighbours.
void AddOpenMotion(const SolvedChain& chain, const MotionParts& learned,
                   const ForRanges& for_ranges, std::vector<StateCovariance>* covariances);

/// The same of a chain's last state alone, by the intervals before the last one: of that OpenMotion
/// knows more, of which nothing but the last state's frame tells.
StateCovariance OpenBeforeTheLast(const SolvedChain& chain, const MotionParts& learned);

/// The same for a window that frames come into and leave: each interval is looked at once, when
/// enough has come after it, and remembered for as long as a state that it reaches is there.
class OpenMotionOfWindow {
 public:
  /// At the intervals near the window's oldest state, or at all of them. `oldest`: the chain's
  /// state that it is.
  void Look(const SolvedChain& chain, int oldest, const MotionParts& learned, bool at_all);
  /// What the covariance of a state of the window lacks, by the intervals looked at.
  StateCovariance Of(int state) const { return near_.Of(state); }
  /// The oldest states have left.
  void Forget(int n_states);

 private:
  OpenIntervals near_;
  int next_ = 0;  // the interval to be looked at
};

}  // namespace tagtwist::internal
