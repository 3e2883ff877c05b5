#pragma once
#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/tag_elsewhere.h"
#include "frontend/base/statistics/thinned_sample.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// What a detection that was left out looks like, back-projected from the estimated pose onto the
/// plane that the map puts its tag on.
enum class TagFault {
  kDisplaced,  // a tag, elsewhere or turned
  kWrongId,    // lies where the map has another tag
  kMirrored,   // its corners run the wrong way round
};

/// One detection that was left out.
struct TagDisagreement {
  TagFault fault = TagFault::kDisplaced;
  Eigen::Vector2d shift_m = Eigen::Vector2d::Zero();  // of its centre, in the map's tag frame
  double distance_m = 0;  // root mean square distance of its corners from the map's
};

/// Where a tag of the map is seen from a pose that it was not made with; nullopt when the rays
/// through its corners do not meet the tag's plane.
std::optional<TagDisagreement> JudgeTag(const EstimatorSetup& setup, const Pose& world_from_body,
                                        const TagDetection& detection);

/// Of `seen`, the tags that a frame with its final state was made without and that lie elsewhere.
std::vector<TagElsewhere> TagsElsewhere(const EstimatorSetup& setup, const GraphFrame& frame,
                                        const std::vector<TagDetection>& seen);

/// Collects, frame by frame, the tags that an estimate was made without, and names those that
/// disagree with the map as a rule: "tag 17 disagrees with the map by 41 mm in 212 frames".
class TagAudit {
 public:
  /// A frame with its final state: what was seen in it, and in frame.tags what of it was used.
  void Add(const EstimatorSetup& setup, const GraphFrame& frame,
           const std::vector<TagDetection>& seen);
  /// One line each: tags that disagree, in order of their ids; then what is left, in numbers.
  std::vector<std::string> Warnings() const;

 private:
  struct History {
    int seen = 0;       // frames
    int off_plane = 0;  // of those, left out and not to be placed
    std::array<ThinnedSample<TagDisagreement>, 3> left_out;  // by fault
  };
  std::map<int, History> tags_;  // by id
  // Ids left out of each frame none of whose tags could be used.
  ThinnedSample<std::vector<int>> useless_frames_;
};

}  // namespace tagtwist::internal
