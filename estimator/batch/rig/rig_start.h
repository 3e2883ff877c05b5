#pragma once
#include <vector>

#include "estimator/graph/trajectory.h"
#include "estimator/result/estimate.h"
#include "frontend/base/result.h"
#include "frontend/types/pose.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {

/// How a camera stands against a rig's first, and its clock: what is to be added to its stamps.
struct RelativeMount {
  Pose cam_from_first;
  double clock_s = 0;
  int frames = 0;  // that say it
};

/// From what each says of its own way, estimated alone as if it were the body (in whose place the
/// map is where they stand): the clock under which the pose between them varies least, within
/// four `clock_sigma_s` and with that prior, and a robust mean of that pose. An error, in words,
/// where they have too little time in common. O(frames).
Result<RelativeMount> StartMount(const Trajectory& first, const std::vector<FrameEstimate>& frames,
                                 MountedOn mounted_on, double clock_sigma_s);

}  // namespace tagtwist::internal
