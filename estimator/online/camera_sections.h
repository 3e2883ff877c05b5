#pragma once
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/setup/yaml_value.h"
#include "frontend/types/pose.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {

/// Where a camera and its mount are from, in words, and what its file says and is not used.
struct CameraOrigin {
  std::string camera, mount;
  std::vector<std::string> notes;
  bool mount_is_given = true;  // false: neither the section nor its file has one
};

/// "focal length +- 0.1 %, centre +- 0.4 px": what is known of a lens's errors; empty: of neither.
std::string LensSigmaText(const RigCamera& camera);

/// A file named in another one, relative to that one's folder.
std::string BesideFile(const std::string& file, const std::string& name);

/// The camera of a calibration file, and, unless `has_mount`, its mount.
Status TakeCamera(const std::string& path, const std::string& name, bool has_mount,
                  const Limits& limits, RigCamera* camera, CameraOrigin* origin);
/// The section `camera`: its keys, or the file that it names.
Status ReadCamera(const YamlValue& node, bool has_mount, const Limits& limits, RigCamera* camera,
                  CameraOrigin* origin);
/// The section `cam_from_body`. `own_lens`: it stands beside the lens that is used.
Status ReadExtrinsic(const YamlValue& node, bool own_lens, RigCamera* camera);

/// One camera of the section `cameras`, and where in the data set its recording is.
struct CameraEntry {
  RigCamera camera;
  MountedOn mounted_on = MountedOn::kBody;
  CameraOrigin origin;
  std::string recording, topic;
};
/// Those of a calibration that has several, all or the named ones (ReadRigFile).
Result<std::vector<CameraEntry>> CamerasOfFile(const std::string& path,
                                               const std::vector<std::string>& names,
                                               const Limits& limits);
/// The section `cameras`: a list, each with a name of its own and a mount, either all on the body
/// or all in W; or `file` and optionally `names`, of CamerasOfFile.
Result<std::vector<CameraEntry>> ReadCameras(const YamlValue& node, const Limits& limits);

}  // namespace tagtwist::internal
