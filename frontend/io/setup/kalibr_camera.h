#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/io/setup/other_cameras.h"

namespace tagtwist::internal {

/// A camera of Kalibr's: pinhole with radtan, equidistant, fov or none; omni with radtan or none;
/// ds and eucm; with T_cam_imu, or inverted T_imu_cam (OpenVINS) or T_BS (EuRoC), as its mount.
/// T_cn_cnm1 and timeshift_cam_imu are read, and noted nowhere: ReadOneOfSeveral tells them.
Result<CameraFile> ReadKalibrCamera(const YamlValue& node);

/// A rigid transform as four rows of four.
Result<Pose> ReadRigidMatrix(const YamlValue& node);

/// cam0, cam1, ... of a Kalibr camchain, in its order.
std::vector<const YamlValue*> KalibrCameras(const YamlValue& root);

/// The camera of that name from a file that may have several, a camchain of Kalibr's (cam0, cam1,
/// ...) or a calibration of Basalt's (likewise, in their order); without a name, the only one.
/// nullopt: it is neither.
std::optional<Result<CameraFile>> ReadOneOfSeveral(const YamlValue& root, const std::string& name);

}  // namespace tagtwist::internal
