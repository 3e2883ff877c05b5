#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frontend/closed_form_options.h"
#include "frontend/flow/optical_flow.h"
#include "frontend/flow/twist_ransac.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"
#include "frontend/types/tag_map.h"
#include "frontend/types/tag_planes.h"

namespace tagtwist::internal {

/// The seed's method, frame after frame: pose by homography, twist by flow and RANSAC, low-pass.
/// The flow is that of all tracks, on tags too; where fewer than three tracks were followed (no
/// image), that of the corners of the tags seen in both frames. The twist needs the frame's pose.
class ClosedFormEstimator {
 public:
  ClosedFormEstimator(const Camera& camera, const Pose& cam_from_body, const TagMap& map,
                      const ClosedFormOptions& options, MountedOn mounted_on = MountedOn::kBody);

  /// Closed form of the next frame. Stamps must grow. Tags are in the map (FilterTags); tracks are
  /// sorted by id.
  ClosedForm Update(int64_t t_ns, const std::vector<TagDetection>& tags,
                    const std::vector<TrackObservation>& tracks);

 private:
  std::vector<FlowPoint> Flow(const Pose& world_from_cam, double dt_s,
                              const std::vector<TagDetection>& tags,
                              const std::vector<TrackObservation>& tracks) const;
  void UpdateTwists(int64_t t_ns, const std::vector<FlowPoint>& flow, double dt_s,
                    ClosedForm* closed_form);

  Camera camera_;
  Pose cam_from_body_;
  MountedOn mounted_on_;
  TagMap map_;
  ClosedFormOptions options_;
  TagPlanes planes_;

  std::optional<int64_t> last_t_ns_;
  std::vector<TagDetection> last_tags_;
  std::vector<TrackObservation> last_tracks_;
  double sum_dt_s_ = 0;  // of the intervals without a gap
  int n_dt_ = 0;
  std::optional<Twist> low_pass_;
  int64_t low_pass_t_ns_ = 0;
};

}  // namespace tagtwist::internal
