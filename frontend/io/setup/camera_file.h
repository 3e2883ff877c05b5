#pragma once
#include <string>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/setup/other_cameras.h"

namespace tagtwist::internal {

/// Reads a camera from a calibration (docs/formats.md), told apart by its content: Kalibr
/// camchain, OpenCV YAML or XML, ROS camera_info, as text or in a bag, or the section `camera` of a
/// configuration. `name` chooses among several cameras (cam1) or topics of a bag; it may be empty
/// where there is but one. Members that say nothing of the camera are ignored. Other projections
/// than the pinhole and other lenses than radtan and equidistant are refused.
Result<CameraFile> ReadCameraFile(const std::string& path, const std::string& name,
                                  const Limits& limits = {});

}  // namespace tagtwist::internal
