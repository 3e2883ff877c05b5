#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/track_planes.h"
#include "frontend/base/check.h"
#include "frontend/types/ray.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {

Pose MountedCamera::CamFromMap(const Pose& world_from_body) const {
  return mounted_on == MountedOn::kBody ? cam_from_body * Inverse(world_from_body)
                                        : cam_from_body * world_from_body;
}

Pose MountedCamera::BodyOf(const Pose& cam_from_map) const {
  return mounted_on == MountedOn::kBody ? Inverse(cam_from_map) * cam_from_body
                                        : Inverse(cam_from_body) * cam_from_map;
}

namespace {

void CheckIsOfRig(int index, int n_cameras) {
  TAGTWIST_CHECK(index >= 0 && index < n_cameras, "a tag is of the rig's cameras, but " +
                                                      std::to_string(index) + " of " +
                                                      std::to_string(n_cameras) + " is told");
}

}  // namespace

FixedCameras::FixedCameras(const EstimatorSetup& setup) {
  for (int i = 0; i < setup.n_cameras(); ++i) {
    const MountedCamera camera = setup.CameraOf(i);
    cameras_.push_back(std::make_shared<const FixedCamera>(camera.camera, camera.cam_from_body,
                                                           camera.mounted_on));
  }
}

const std::shared_ptr<const FixedCamera>& FixedCameras::Of(int index) const {
  CheckIsOfRig(index, static_cast<int>(cameras_.size()));
  return cameras_[static_cast<size_t>(index)];
}

MountedCamera EstimatorSetup::CameraOf(int index) const {
  if (index == 0) return {camera, cam_from_body, line_time_s, mounted_on, camera_covariance};
  CheckIsOfRig(index, n_cameras());
  const RigCamera& other = others[static_cast<size_t>(index) - 1];
  return {other.camera, other.cam_from_body, other.line_time_s, mounted_on, other.covariance};
}

std::vector<Camera> EstimatorSetup::Cameras() const {
  std::vector<Camera> out = {camera};
  for (const RigCamera& other : others) out.push_back(other.camera);
  return out;
}

std::optional<Eigen::Vector2d> PointOnPlane(const EstimatorSetup& setup,
                                            const Pose& world_from_body,
                                            const Pose& world_from_plane,
                                            const Eigen::Vector2d& pixel, int camera) {
  const MountedCamera seen_by = setup.CameraOf(camera);
  const auto normalised = seen_by.camera.Unproject(pixel);
  if (!normalised) return std::nullopt;
  const Pose plane_from_map = Inverse(world_from_plane);
  const Pose plane_from_cam =
      seen_by.mounted_on == MountedOn::kBody
          ? plane_from_map * world_from_body * Inverse(seen_by.cam_from_body)
          : plane_from_map * Inverse(seen_by.CamFromMap(world_from_body));
  const Ray ray{plane_from_cam.translation(),
                plane_from_cam.rotation() * normalised->homogeneous()};
  const double depth = DistanceToPlane(ray, Eigen::Vector3d::UnitZ(), 0);
  constexpr double kMaxDepthM = 100;  // farther is a grazing view: no use, and badly conditioned
  if (!(depth > 0.01 && depth < kMaxDepthM)) return std::nullopt;
  return ray.At(depth).head<2>();
}

bool EstimatorSetup::HasRollingShutter() const {
  return line_time_s != 0 || std::any_of(others.begin(), others.end(), [](const RigCamera& other) {
           return other.line_time_s != 0;
         });
}

EstimatorSetup MakeEstimatorSetup(const SetUp& set_up, const EstimatorOptions& options) {
  const RigCamera& camera = set_up.rig.front();
  EstimatorSetup out;
  out.camera = camera.camera;
  out.line_time_s = camera.line_time_s;
  out.cam_from_body = camera.cam_from_body;
  out.camera_covariance = camera.covariance;
  out.mounted_on = set_up.rig.mounted_on;
  out.others.assign(set_up.rig.cameras.begin() + 1, set_up.rig.cameras.end());
  out.map = set_up.map;
  out.options = options;
  for (const RigCamera& one : set_up.rig.cameras) out.camera_names.push_back(one.name);
  if (out.HasRollingShutter() || out.mounted_on != MountedOn::kBody) out.options.use_tracks = false;
  if (out.n_cameras() > 1) out.options.clock = ClockChoice::kStamps;
  out.planes = FindTrackPlanes(set_up.map);
  return out;
}

}  // namespace tagtwist::internal
