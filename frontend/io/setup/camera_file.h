#pragma once
#include <optional>
#include <string>

#include "frontend/base/result.h"
#include "frontend/types/camera.h"
#include "frontend/types/pose.h"

namespace tagtwist {

/// What a calibration file says of one camera.
struct CameraFile {
  Camera camera;
  double line_time_s = 0;             // of a rolling shutter; only tagtwist's own files tell it
  std::optional<Pose> cam_from_body;  // Kalibr's T_cam_imu: the body is the IMU
};

/// Reads a camera from a calibration (docs/formats.md), told apart by its content: Kalibr
/// camchain, OpenCV YAML or XML, ROS camera_info, or the section `camera` of a configuration.
/// `name` chooses among several cameras (cam1); it may be empty where there is but one. Members
/// that say nothing of the camera are ignored. Other projections than the pinhole and other lenses
/// than radtan and equidistant are refused.
Result<CameraFile> ReadCameraFile(const std::string& path, const std::string& name);

}  // namespace tagtwist
