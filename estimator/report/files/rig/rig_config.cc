#include "estimator/report/files/rig/rig_config.h"

#include <nlohmann/json.hpp>

namespace tagtwist::internal {
namespace {

nlohmann::ordered_json ThreeJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

std::string FormatRigConfig(const RigCalibration& rig, const std::string& sections) {
  std::string out =
      "# Mounts and clocks refined by tagtwist_estimate --calibrate; +- is one standard "
      "deviation.\n";
  for (const std::string& line : RigText(rig)) out += "# " + line + "\n";
  return out + sections;
}

nlohmann::ordered_json RigJson(const RigCalibration& rig) {
  nlohmann::ordered_json out;
  out["rounds"] = rig.rounds;
  out["cameras"] = nlohmann::ordered_json::array();
  for (const MountFound& camera : rig.cameras) {
    out["cameras"].push_back({{"name", camera.name},
                              {"frames", camera.frames},
                              {"mount_turn_rad", ThreeJson(camera.change.head<3>())},
                              {"mount_turn_sigma_rad", ThreeJson(camera.sigma.head<3>())},
                              {"mount_shift_m", ThreeJson(camera.change.tail<3>())},
                              {"mount_shift_sigma_m", ThreeJson(camera.sigma.tail<3>())},
                              {"clock_s", camera.clock_s},
                              {"clock_sigma_s", camera.clock_sigma_s},
                              {"clock_is_taken", camera.clock_is_seen},
                              {"hardly_shown", camera.unseen}});
  }
  return out;
}

}  // namespace tagtwist::internal
