#pragma once
#include <cstddef>
#include <deque>
#include <vector>

#include "estimator/jobs/kept/kept_states.h"
#include "estimator/jobs/run_options.h"
#include "estimator/result/estimate.h"
#include "estimator/result/seen_body.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// The states of a window's bodies on their way out: put in W where the first body carries the
/// camera that sees the others, told to those who ask (RunOptions), and kept.
class ToldBodies {
 public:
  /// `are_carried`: the others are seen from the first one.
  ToldBodies(size_t bodies, bool are_carried, const RunOptions& options);

  /// States of a frame at its arrival, of all bodies, the first one's in W already. The others' are
  /// put there.
  Status Tell(std::vector<SeenBody>* bodies);
  /// Frames of a body at the lag, as its window has them.
  Status TellLagged(size_t body, const std::vector<FrameEstimate>& lagged);
  KeptFrames& kept(size_t body) { return kept_[body]; }

 private:
  // A carrier's frames at the lag and those of a body about it, which come one by one but not at
  // the same time.
  struct Pairs {
    std::deque<FrameEstimate> carriers, about_body;
  };
  bool IsCarried(size_t body) const { return body > 0 && are_carried_; }
  Status TellOneLagged(size_t body, const FrameEstimate& frame);
  Status TellPairs(size_t body);

  bool are_carried_;
  RunOptions options_;
  std::vector<Pairs> pairs_;  // of all bodies; the first has none
  std::vector<KeptFrames> kept_;
};

}  // namespace tagtwist::internal
