#include "estimator/batch/rig/rig_calibration.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

constexpr double kDegPerRad = 57.29577951308232;

}  // namespace

std::vector<std::string> RigText(const RigCalibration& found) {
  std::vector<std::string> out;
  for (const MountFound& camera : found.cameras) {
    const auto largest = [&](Eigen::Index first) {
      return camera.sigma.segment<3>(first).maxCoeff();
    };
    std::string text =
        Format("%s: its mount is %.2f +- %.2f mm and %.3f +- %.3f deg from where it was given",
               camera.name.c_str(), 1e3 * camera.change.tail<3>().norm(), 1e3 * largest(3),
               kDegPerRad * camera.change.head<3>().norm(), kDegPerRad * largest(0));
    if (camera.clock_sigma_s > 0) {
      text += Format(", its clock %+.3f +- %.3f ms%s", 1e3 * camera.clock_s,
                     1e3 * camera.clock_sigma_s, camera.clock_is_seen ? "" : " (left as given)");
    }
    text += Format("; by %d of its frames", camera.frames);
    if (!camera.unseen.empty()) {
      text += "; this recording hardly shows its";
      for (const std::string& name : camera.unseen) text += " " + name;
    }
    out.push_back(std::move(text));
  }
  return out;
}

}  // namespace tagtwist::internal
