#include "estimator/graph/reprojection.h"

namespace tagtwist::internal {

std::vector<double> ReprojectionErrors(const EstimatorSetup& setup, const GraphFrame& frame) {
  std::vector<double> errors;
  const Pose body_from_world = Inverse(frame.state.world_from_body);
  for (const TagDetection& tag : frame.tags) {
    const MountedCamera seen_by = setup.CameraOf(tag.camera);
    const Pose cam_from_world = seen_by.cam_from_body * body_from_world;
    const auto& corners = setup.map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      Eigen::Vector2d pixel;
      if (!seen_by.camera.Project(cam_from_world * corners[c], &pixel)) continue;
      errors.push_back((pixel - tag.corners[c]).norm());
    }
  }
  return errors;
}

}  // namespace tagtwist::internal
