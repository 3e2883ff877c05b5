#include "estimator/start/mirror.h"

#include "estimator/graph/noise_model.h"
#include "estimator/rig/rig_pose.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {

std::optional<double> CornerCost(const EstimatorSetup& setup, const NoiseModel& noise,
                                 const GraphFrame& frame, const Pose& world_from_body) {
  double sum = 0;
  for (const TagDetection& tag : frame.tags) {
    const MountedCamera seen_by = setup.CameraOf(tag.camera);
    const TagReprojection residual({setup.map.CornersInWorld(tag.id), tag.corners,
                                    CornerCovariance(setup, tag, noise.corner_sigma_px)},
                                   seen_by.camera, seen_by.cam_from_body, seen_by.mounted_on);
    Eigen::Matrix<double, 8, 1> r;
    if (!residual.Linearize(world_from_body.params.data(), &r, nullptr)) return std::nullopt;
    sum += 0.5 * r.squaredNorm();
  }
  return sum;
}

std::optional<Mirror> MirrorOf(const EstimatorSetup& setup, const NoiseModel& noise,
                               const GraphFrame& frame) {
  const Pose& pose = frame.state.world_from_body;
  const auto mirrored = MirroredPoseOf(setup, frame.tags, pose);
  if (!mirrored) return std::nullopt;
  const auto cost = CornerCost(setup, noise, frame, pose);
  const auto of_mirrored = CornerCost(setup, noise, frame, *mirrored);
  if (!cost || !of_mirrored) return std::nullopt;
  return Mirror{AngleBetween(pose, *mirrored), *of_mirrored - *cost};
}

}  // namespace tagtwist::internal
