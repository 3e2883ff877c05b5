#include "estimator/online/imu/imu_section.h"

#include <cmath>
#include <vector>

#include "estimator/online/camera_sections.h"
#include "frontend/io/setup/kalibr_camera.h"
#include "frontend/io/setup/tag_map_reader.h"
#include "frontend/io/setup/yaml_reader.h"

namespace tagtwist::internal {
namespace {

// The keys of a calibration that are the section's own; whether there were any.
Result<bool> ReadDensities(const YamlValue& imu, ImuOptions* options) {
  bool any = false;
  const auto read = [&](const char* name, double* value) -> Status {
    const YamlValue* node = Member(imu, name);
    if (node == nullptr) return Ok();
    any = true;
    return ReadValue(*node, value);
  };
  for (const Status& status :
       {read("gyroscope_noise_density", &options->gyroscope_noise_density),
        read("accelerometer_noise_density", &options->accelerometer_noise_density),
        read("gyroscope_random_walk", &options->gyroscope_random_walk),
        read("accelerometer_random_walk", &options->accelerometer_random_walk)}) {
    if (!status) return status.error();
  }
  return any;
}

// T_i_b: IMU from body (Kalibr); T_BS: body from sensor (EuRoC).
Status ReadPlace(const YamlValue& imu, Pose* body_from_imu) {
  for (const char* name : {"T_i_b", "T_BS"}) {
    const YamlValue* node = Member(imu, name);
    if (node == nullptr) continue;
    const auto pose = ReadRigidMatrix(*node);
    if (!pose) return pose.error();
    *body_from_imu = std::string(name) == "T_BS" ? *pose : Inverse(*pose);
  }
  return Ok();
}

Status ReadBodyFromImu(const YamlValue& node, Pose* body_from_imu) {
  YamlSection section(node);
  const auto rotation = ReadRotation(&section);
  const auto translation = ReadVector3(section.Require("translation_m"), &section);
  if (!rotation) section.Keep(node.Refuse("rotation or quaternion_xyzw, got neither"));
  if (rotation && translation) *body_from_imu = MakePose(*rotation, *translation);
  return section.Finish();
}

Status ReadImuFile(const std::string& path, const Limits& limits, ImuOptions* options) {
  const auto root = ReadYaml(path, limits);
  if (!root) return root.error();
  const YamlValue* below = Member(*root, "imu0");
  const YamlValue& imu = below != nullptr ? *below : *root;
  const auto any = ReadDensities(imu, options);
  if (!any) return any.error();
  if (!*any) {
    return Error{path +
                 ": expected an IMU's gyroscope_noise_density and its like (Kalibr's imu.yaml, "
                 "EuRoC's sensor.yaml), got none"};
  }
  if (const auto problem = options->Problem()) return Error{path + ": " + *problem};
  return ReadPlace(imu, &options->body_from_imu);
}

}  // namespace

Status ReadImu(const YamlValue& node, const Limits& limits, ImuOptions* options) {
  YamlSection section(node);
  std::string file;
  section("file", file);
  if (!file.empty()) {
    section.Keep(ReadImuFile(BesideFile(node.file, file), limits, options));
  }
  ImuOptions::VisitFields(*options, section);
  if (const YamlValue* place = section.Find("body_from_imu")) {
    section.Keep(ReadBodyFromImu(*place, &options->body_from_imu));
  }
  section.KeepProblem(options->Problem());
  return section.Finish();
}

}  // namespace tagtwist::internal
