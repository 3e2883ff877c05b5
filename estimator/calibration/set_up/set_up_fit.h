#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Tags of one frame as they were seen.
struct SeenTags {
  int64_t t_ns = 0;
  std::vector<TagDetection> tags;
};

/// What may be wrong with a set-up as a whole.
struct SetUpChange {
  double log_focal = 0;       // both focal lengths times its exponential
  double log_resolution = 0;  // focal lengths and centre times its exponential
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  // added to the centre
  Eigen::Vector2d radial = Eigen::Vector2d::Zero();     // added to k1 and k2
  double log_size = 0;     // tags about their centres times its exponential
  double line_time_s = 0;  // of a rolling shutter, added
  Eigen::Vector2d log_stretch = Eigen::Vector2d::Zero();  // tags' places along the map's x and y
  double log_squeeze = 0;  // focal length and centre along the image's x times its exponential
};
constexpr size_t kSetUpChanges = 11;  // numbers in a SetUpChange, in its order
/// Which of them are free.
using FreeChanges = std::array<bool, kSetUpChanges>;

/// A frame with the pose that it starts from, and those of the frames beside it where they are
/// known: their difference says how points move while an image is read out.
struct PosedFrame {
  SeenTags seen;  // all in the map
  Pose cam_from_world;
  Pose cam_before, cam_after;
  double between_s = 0;  // from before to after; 0: not known
};

struct SetUpFit {
  SetUpChange change;
  double median_px = 0;  // over all tags: RMS of its corners' errors
  double cost = 0;       // sum over corners of the robust square (Huber, by tag) [px^2]
  size_t corners = 0;
};

/// Least squares over the frames' poses and the free changes, by Levenberg-Marquardt with the
/// poses eliminated. No change of the map but its size, and no prior: for faults, not for
/// calibration. `huber_px`: of a tag's RMS.
SetUpFit FitSetUp(const std::vector<PosedFrame>& frames, const Camera& camera, const TagMap& map,
                  const FreeChanges& free, const SetUpChange& start, double huber_px);

/// The camera with its part of a change.
Camera Changed(const Camera& camera, const SetUpChange& change);

}  // namespace tagtwist::internal
