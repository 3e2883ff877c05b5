#include "apps/config_flags.h"

#include <gflags/gflags.h>

DEFINE_string(
    config, "",
    "Camera, mount, tag map and options (YAML); configs/course.yaml's values without it.");
DEFINE_string(camera_file, "",
              "Calibration to take the camera from: Kalibr camchain, OpenCV YAML or XML, ROS "
              "camera_info, or a configuration. Before the one in --config.");
DEFINE_string(camera, "", "Which camera of --camera_file, where it has several: cam1.");

namespace tagtwist {

FlagGroup ConfigFlags() { return {"Camera and map", {"config", "camera_file", "camera"}}; }

Result<ConfigFiles> ConfigFilesFromFlags() {
  if (!FLAGS_camera.empty() && FLAGS_camera_file.empty()) {
    return Error{"--camera: expected with --camera_file"};
  }
  return ConfigFiles{FLAGS_config, FLAGS_camera_file, FLAGS_camera};
}

}  // namespace tagtwist
