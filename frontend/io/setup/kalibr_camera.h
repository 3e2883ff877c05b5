#pragma once
#include <optional>
#include <string>

#include "frontend/base/result.h"
#include "frontend/io/setup/other_cameras.h"

namespace tagtwist::internal {

/// A camera of Kalibr's: pinhole with radtan, equidistant, fov or none; omni with radtan or none;
/// ds and eucm; with T_cam_imu, or inverted T_imu_cam (OpenVINS) or T_BS (EuRoC), as its mount.
Result<CameraFile> ReadKalibrCamera(const YamlValue& node);

/// The camera of that name from a file that may have several, a camchain of Kalibr's (cam0, cam1,
/// ...) or a calibration of Basalt's (likewise, in their order); without a name, the only one.
/// nullopt: it is neither.
std::optional<Result<CameraFile>> ReadOneOfSeveral(const YamlValue& root, const std::string& name);

}  // namespace tagtwist::internal
