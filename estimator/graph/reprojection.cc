#include "estimator/graph/reprojection.h"

namespace tagtwist::internal {

void AddReprojectionErrors(const EstimatorSetup& setup, const Pose& world_from_body,
                           const TagDetection& tag, std::vector<double>* errors) {
  const MountedCamera seen_by = setup.CameraOf(tag.camera);
  const Pose cam_from_map = seen_by.CamFromMap(world_from_body);
  const auto& corners = setup.map.CornersInWorld(tag.id);
  for (size_t c = 0; c < 4; ++c) {
    Eigen::Vector2d pixel;
    if (!seen_by.camera.Project(cam_from_map * corners[c], &pixel)) continue;
    errors->push_back((pixel - tag.corners[c]).norm());
  }
}

std::vector<double> ReprojectionErrors(const EstimatorSetup& setup, const GraphFrame& frame) {
  std::vector<double> errors;
  errors.reserve(4 * frame.tags.size());
  for (const TagDetection& tag : frame.tags) {
    AddReprojectionErrors(setup, frame.state.world_from_body, tag, &errors);
  }
  return errors;
}

}  // namespace tagtwist::internal
