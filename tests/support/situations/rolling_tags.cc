#include "tests/support/situations/rolling_tags.h"

namespace tagtwist::internal {
namespace {

Eigen::Vector2d PixelOf(const EstimatorSetup& setup, const Pose& world_from_body,
                        const Eigen::Vector3d& corner) {
  Eigen::Vector2d out;
  setup.camera.Project(setup.cam_from_body * (Inverse(world_from_body) * corner), &out);
  return out;
}

}  // namespace

void RollTags(const EstimatorSetup& setup, const std::function<Pose(double s)>& pose_after,
              std::vector<TagDetection>* tags) {
  constexpr int kRounds = 8;  // until the row agrees with its time
  for (TagDetection& tag : *tags) {
    const auto& corners = setup.map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      const Eigen::Vector2d at_stamp = PixelOf(setup, pose_after(0), corners[c]),
                            noise = tag.corners[c] - at_stamp;
      Eigen::Vector2d seen = at_stamp;
      for (int i = 0; i < kRounds; ++i) {
        seen = PixelOf(setup, pose_after(setup.line_time_s * (seen + noise).y()), corners[c]);
      }
      tag.corners[c] = seen + noise;
    }
  }
}

}  // namespace tagtwist::internal
