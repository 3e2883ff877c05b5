#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

struct FramePoseOptions {
  double agree_px = 4.0;        // a tag agrees when its worst corner is predicted to this [px], > 0
  double agree_fraction = 0.1;  // or to this fraction of its mean side in the image, >= 0, or four
                                // deviations of its corners' own covariance
  int max_candidate_tags = 8;   // the largest ones propose poses, >= 1
  double ambiguity_px = 0.5;    // corner noise that tells two minima apart [px], > 0

  std::optional<std::string> Problem() const;
};

enum class FramePoseStatus {
  kOk,
  kNoTags,  // none in the map
  kNoPose,  // no tag gives a pose: corners degenerate
};

/// The pose of one frame by its tags alone: what the graph may start from.
struct FramePose {
  FramePoseStatus status = FramePoseStatus::kNoTags;
  Pose world_from_body;            // least squares over the agreeing tags
  std::vector<bool> tag_inlier;    // one a tag, in the order given
  double rms_px = 0;               // per corner, over the agreeing tags: sqrt(mean |error|^2)
  std::vector<Pose> alternatives;  // world_from_body: other minima that the corners do not exclude
};

/// Pose that most tags of a frame agree on. Candidates: the homography of all tags on the main
/// plane and of single tags, with both minima of each; scored by the tags they predict; refined by
/// RefinePose on all corners with the full camera model. Wrong ids and stray tags come out as
/// tag_inlier = false. When the tags that agree lie on one plane and are seen nearly face-on, the
/// mirrored minimum is kept among the alternatives.
FramePose FindFramePose(const std::vector<TagDetection>& tags, const TagMap& map,
                        const Camera& camera, const Pose& cam_from_body,
                        const FramePoseOptions& options = {});

/// The other world_from_body under which tags that lie on one plane look the same from afar: the
/// rotation mirrored along the line of sight to their centroid, which keeps its place. No
/// refinement. nullopt without tags, or with tags on several planes. All ids must be in the map.
std::optional<Pose> MirroredPose(const std::vector<TagDetection>& tags, const TagMap& map,
                                 const Pose& cam_from_body, const Pose& world_from_body);

}  // namespace tagtwist::internal
