#include "estimator/online/imu/imu_section.h"

#include <cmath>
#include <vector>

#include "estimator/online/camera_sections.h"
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

// T_i_b or T_BS, 4 x 4: the body is the IMU.
Status CheckIsBody(const YamlValue& imu) {
  for (const char* name : {"T_i_b", "T_BS"}) {
    const YamlValue* node = Member(imu, name);
    if (node == nullptr) continue;
    std::vector<double> n;
    if (const Status read = ReadMatrix(*node, &n); !read) return read;
    double off = n.size() == 16 ? 0 : 1;
    for (size_t i = 0; i < n.size() && n.size() == 16; ++i) {
      off = std::max(off, std::abs(n[i] - (i % 5 == 0 ? 1 : 0)));
    }
    if (!(off < 1e-6)) return node->Refuse("the identity, for the body is the IMU");
  }
  return Ok();
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
  return CheckIsBody(imu);
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
  section.KeepProblem(options->Problem());
  return section.Finish();
}

}  // namespace tagtwist::internal
