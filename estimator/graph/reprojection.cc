#include "estimator/graph/reprojection.h"

namespace tagtwist::internal {

std::vector<double> ReprojectionErrors(const EstimatorSetup& setup, const GraphFrame& frame) {
  std::vector<double> errors;
  for (const TagDetection& tag : frame.tags) {
    const MountedCamera seen_by = setup.CameraOf(tag.camera);
    const Pose cam_from_map = seen_by.CamFromMap(frame.state.world_from_body);
    const auto& corners = setup.map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      Eigen::Vector2d pixel;
      if (!seen_by.camera.Project(cam_from_map * corners[c], &pixel)) continue;
      errors.push_back((pixel - tag.corners[c]).norm());
    }
  }
  return errors;
}

}  // namespace tagtwist::internal
