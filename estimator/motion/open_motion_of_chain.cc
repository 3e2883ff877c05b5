#include "estimator/motion/open_motion_of_chain.h"

#include <algorithm>
#include <utility>

namespace tagtwist::internal {

void OpenMotionOfWindow::Look(const SolvedChain& chain, int oldest, const MotionParts& learned,
                              bool at_all) {
  if (chain.covariance.bandwidth() != 1) return;
  const int intervals = chain.covariance.size() - oldest - 1,
            last = at_all ? intervals : std::min(OpenIntervals::kReach, intervals);
  for (; next_ < last; ++next_) {
    OpenParts open = OpenAfter(oldest + next_, chain, learned);
    open.angular.first_state -= oldest;
    open.linear.first_state -= oldest;
    near_.Add(std::move(open));
  }
}

void OpenMotionOfWindow::Forget(int n_states) {
  next_ = std::max(next_ - n_states, 0);
  near_.CountFrom(n_states);
}

// State after state, as of a window.
void AddOpenMotion(const SolvedChain& chain, const MotionParts& learned,
                   const ForRanges& for_ranges, std::vector<StateCovariance>* covariances) {
  if (chain.covariance.bandwidth() != 1) return;
  for_ranges(covariances->size(), [&](size_t first, size_t last) {
    const size_t reach = OpenIntervals::kReach, from = first - std::min(first, reach);
    OpenMotionOfWindow window;
    for (size_t k = from; k < last; ++k) {
      window.Look(chain, static_cast<int>(k), learned, /*at_all=*/false);
      if (k >= first) (*covariances)[k] += window.Of(0);
      window.Forget(1);
    }
  });
}

StateCovariance OpenBeforeTheLast(const SolvedChain& chain, const MotionParts& learned) {
  const int last = chain.covariance.size() - 1;
  OpenIntervals near;
  if (chain.covariance.bandwidth() != 1) return near.Of(last);
  MotionParts open = learned;  // one before those of which next to nothing is open adds less still
  for (int k = last - 2;
       k >= std::max(last - OpenIntervals::kReach, 0) && (open.linear || open.angular); --k) {
    OpenParts parts = OpenAfter(k, chain, open, last);
    open = {!parts.linear.spreads.empty(), !parts.angular.spreads.empty()};
    near.Add(std::move(parts));
  }
  return near.Of(last);
}

}  // namespace tagtwist::internal
