#pragma once
#include "estimator/live/stopwatch.h"
#include "frontend/base/time_up.h"

namespace tagtwist::internal {

/// The time that a frame may take, from when it is taken up. Detection stops at half of it and the
/// solve at four fifths, for neither stops at once, and something comes after.
class FrameDeadline {
 public:
  explicit FrameDeadline(double ms) : ms_(ms) {}
  void Start() { watch_ = Stopwatch(); }
  double ms() const { return ms_; }

  /// They refer to this object.
  TimeUp ForDetection() const { return After(0.5); }
  TimeUp ForSolve() const { return After(0.8); }

 private:
  TimeUp After(double share) const {
    return [this, share] { return watch_.ElapsedMs() >= share * ms_; };
  }

  double ms_;
  Stopwatch watch_;
};

}  // namespace tagtwist::internal
