#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimator/result/estimate.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// Stamps that cannot be when the frames were taken: no camera takes one in less than an eighth of
/// its usual interval after the one before; a host that stamps frames as they arrive does. What
/// moved between such frames would be metres a second, surely.
class StampCheck {
 public:
  /// The next frame's stamp; they grow. True where it comes too soon: an eighth of the third
  /// quartile of the latest 32 intervals, once there are three.
  bool ComesTooSoon(int64_t t_ns);
  /// The usual interval, as above; 0 before the second stamp.
  double UsualS() const;
  size_t too_soon() const { return too_soon_; }
  /// Whether it knows what is usual. Before, the first stamps may be anything.
  bool KnowsUsual() const;
  /// How many did, in a line; nullopt where none.
  std::optional<std::string> Warning() const;

 private:
  std::optional<int64_t> last_ns_;
  std::vector<double> intervals_s_;  // the latest, a ring
  size_t next_ = 0;                  // place in it
  size_t too_soon_ = 0;
  int64_t first_ns_ = 0;  // of those
};

/// Whether a body moves faster than any does that is worth a thought (IsWithinReach).
bool MovesBeyondReach(const Twist& twist);

/// What a frame says of its motion is taken away, for its stamp is worth nothing: any that is
/// within reach may be.
void ForgetTwist(FrameEstimate* frame);

}  // namespace tagtwist::internal
