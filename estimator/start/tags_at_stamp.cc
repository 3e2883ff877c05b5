#include "estimator/start/tags_at_stamp.h"

#include "estimator/start/recording_start.h"

namespace tagtwist::internal {

std::vector<TagDetection> TagsAsOfStamp(const EstimatorSetup& setup, const BodyState& at_stamp,
                                        std::vector<TagDetection> tags) {
  const auto project = [&](const BodyState& state, const Eigen::Vector3d& corner,
                           Eigen::Vector2d* pixel) {
    return setup.camera.Project(setup.cam_from_body * (Inverse(state.world_from_body) * corner),
                                pixel);
  };
  for (TagDetection& tag : tags) {
    if (setup.map.Find(tag.id) == nullptr) continue;
    const auto& corners = setup.map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      const BodyState at_row = Predict(at_stamp, setup.line_time_s * tag.corners[c].y());
      Eigen::Vector2d then, later;
      if (!project(at_stamp, corners[c], &then) || !project(at_row, corners[c], &later)) continue;
      tag.corners[c] += then - later;
    }
  }
  return tags;
}

}  // namespace tagtwist::internal
