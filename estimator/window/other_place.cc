#include "estimator/window/other_place.h"

#include "estimator/start/leaps.h"

namespace tagtwist::internal {

bool OtherPlace::Add(const std::optional<Pose>& excluded, const FrameMeasurements& measurement) {
  constexpr int kFrames = 3;
  if (!excluded) {
    if (!measurement.tags.empty()) in_a_row_ = 0;
    return false;
  }
  const double dt_s = ToSeconds(measurement.t_ns - t_ns_);
  if (in_a_row_ > 0 && !IsWithinReach(pose_, *excluded, dt_s)) in_a_row_ = 0;
  t_ns_ = measurement.t_ns;
  pose_ = *excluded;
  if (++in_a_row_ < kFrames) return false;
  in_a_row_ = 0;
  return true;
}

}  // namespace tagtwist::internal
