#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/result/reprojection_errors.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/pose.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Collects ReprojectionErrorsByPlace. Memory does not grow with the frames.
class ReprojectionTally {
 public:
  ReprojectionTally() = default;
  /// The tags of a frame and where its camera was. Stamps must grow.
  void Add(const Camera& camera, const TagMap& map, int64_t t_ns, const Pose& cam_from_world,
           const std::vector<TagDetection>& tags);
  /// The errors of all frames until now.
  ReprojectionErrorsByPlace Errors() const;

 private:
  void AddTag(const Camera& camera, const TagMap& map, int64_t t_ns, const Pose& cam_from_world,
              const TagDetection& tag);
  void CloseBlock();

  std::optional<int64_t> block_ns_;  // where the open block began
  ReprojectionErrorsByPlace errors_;
};

}  // namespace tagtwist::internal
