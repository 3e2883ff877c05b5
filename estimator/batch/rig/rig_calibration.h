#pragma once
#include <string>
#include <vector>

#include "estimator/graph/estimator_options.h"
#include "estimator/systematic/mount_border.h"
#include "frontend/base/for_ranges.h"
#include "frontend/base/result.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {

/// What was found of a camera after a rig's first.
struct MountFound {
  std::string name;
  int frames = 0;                         // with tags of its own
  PoseStep change = PoseStep::Zero();     // of its mount, from as it was given (Difference)
  PoseStep sigma = PoseStep::Zero();      // 0: held
  double clock_s = 0, clock_sigma_s = 0;  // what its clock offset grew by; sigma 0: held
  bool clock_is_seen = false;             // the offset differs from the one given by 3 sigma
  std::vector<std::string> unseen;        // entries that this recording hardly says anything of
};

/// A rig whose mounts and clocks the recording has said.
struct RigCalibration {
  SetUp set_up;  // with the mounts' covariances (RigCamera), and clocks where they are seen
  std::vector<MountFound> cameras;
  int rounds = 0;  // until nothing moved
};

/// How the cameras of a rig stand against its first one, and their clocks, from a recording over
/// the map. Each is estimated alone first (so mounts need not be known); then mounts and clocks are
/// found with the states of all, by Gauss-Newton. What errors of lens, map and corners that last do
/// to them is in their sigmas. Mounts or clocks whose prior is 0 stay as given; other mounts'
/// priors are wide, whatever is told. Lenses and the map stay; the first camera says where the body
/// is. Errors, in words, name the camera.
Result<RigCalibration> CalibrateRig(const SetUp& set_up, const EstimatorOptions& options,
                                    const MountPriors& priors,
                                    const std::vector<FrameMeasurements>& measurements,
                                    const ForRanges& for_ranges = InOneRange);

/// In words, a line each.
std::vector<std::string> RigText(const RigCalibration& found);

}  // namespace tagtwist::internal
