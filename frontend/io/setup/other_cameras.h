#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/io/setup/yaml_reader.h"
#include "frontend/types/camera.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// What a calibration file says of one camera.
struct CameraFile {
  Camera camera;
  double line_time_s = 0;                 // of a rolling shutter; only tagtwist's own files tell it
  Eigen::MatrixXd covariance;             // of the lens, as RigCamera's, or empty; as line_time_s
  std::optional<Pose> cam_from_body;      // the body is the IMU
  std::string mount_key;                  // the member that the mount is from: "T_cam_imu"
  std::optional<Pose> cam_from_previous;  // T_cn_cnm1: from the camera before it in its file
  std::optional<double> imu_time_shift_s;  // timeshift_cam_imu: its stamps plus this are the IMU's
  std::vector<std::string> notes;          // transforms and offsets that are not used: a line each
};

/// A camera as ORB-SLAM (Camera.fx or Camera1.fx and their like), VINS (projection_parameters),
/// PhotonVision (cameraIntrinsics, distCoeffs, resolution) and mrcal (lensmodel) write it; nullopt:
/// the file is of none of them.
std::optional<Result<CameraFile>> ReadOtherCamera(const YamlValue& root);

/// Basalt's calibration: how many cameras it has (0: it is none), and the one of an index.
size_t CountBasaltCameras(const YamlValue& root);
Result<CameraFile> ReadBasaltCamera(const YamlValue& root, size_t index);

}  // namespace tagtwist::internal
