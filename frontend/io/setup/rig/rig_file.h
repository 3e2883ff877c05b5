#pragma once
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/setup/other_cameras.h"

namespace tagtwist::internal {

/// One of several cameras that a calibration has together.
struct CameraOfRig {
  std::string name;           // cam0
  CameraFile file;            // with a mount, whose body is the IMU or, without one, cam0
  std::string topic;          // of its images in a bag, where the calibration says it
  double clock_offset_s = 0;  // its stamps plus this are times of the first camera's clock
};

/// The cameras of a calibration that has several (docs/formats.md), all of them or those named, in
/// that order: a Kalibr camchain, TagSLAM's cameras.yaml with camera_poses.yaml beside it, Basalt,
/// or a folder of EuRoC's, mav0 or the one around it, with cam0/sensor.yaml, cam1/sensor.yaml, ...
/// A mount is the camera's own, or by T_cn_cnm1 that of the camera before it.
/// An error: a camera that nothing ties to the others, or to another body than the first one's.
Result<std::vector<CameraOfRig>> ReadRigFile(const std::string& path,
                                             const std::vector<std::string>& names,
                                             const Limits& limits);

}  // namespace tagtwist::internal
