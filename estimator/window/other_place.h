#pragma once
#include <cstdint>
#include <optional>

#include "frontend/types/measurements.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// Whether the body has been put elsewhere: tags that the motion excludes are faults, until three
/// frames running say the same of another place. Frames without tags say nothing.
class OtherPlace {
 public:
  /// `excluded`: the pose that the frame's tags tell, where the motion excludes it. True at the
  /// third frame; it then begins anew.
  bool Add(const std::optional<Pose>& excluded, const FrameMeasurements& measurement);

 private:
  int in_a_row_ = 0;
  int64_t t_ns_ = 0;  // of the latest
  Pose pose_;
};

}  // namespace tagtwist::internal
