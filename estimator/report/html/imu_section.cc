#include "estimator/report/html/imu_section.h"

#include <string>
#include <vector>

#include "estimator/result/imu_left_out.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

// A vector and its standard deviations, both multiplied by `scale`.
std::vector<std::string> Row(const std::string& name, const Eigen::Vector3d& found,
                             const Eigen::Vector3d& sigma, double scale, int decimals) {
  std::vector<std::string> out = {name};
  for (int a = 0; a < 3; ++a) {
    out.push_back(
        Format("%+.*f \xc2\xb1 %.*f", decimals, scale * found[a], decimals, scale * sigma[a]));
  }
  return out;
}

TextTable Found(const ImuResult& imu) {
  TextTable out = {{"", "x", "y", "z"}};
  const Eigen::Vector3d& g = imu.gravity_world_mps2;
  out.push_back({"gravity in W [m/s\xc2\xb2]", Format("%+.4f", g.x()), Format("%+.4f", g.y()),
                 Format("%+.4f", g.z())});
  out.push_back(
      Row("axes, turned from the set-up's [mrad]", imu.mount_rad, imu.mount_sigma_rad, 1e3, 2));
  out.push_back(Row("place in the body [mm]", imu.imu_in_body_m, imu.imu_in_body_sigma_m, 1e3, 2));
  out.push_back(
      Row("gyro's bias [mrad/s]", imu.gyro_bias_radps, imu.gyro_bias_sigma_radps, 1e3, 3));
  out.push_back(Row("accelerometer's bias [mm/s\xc2\xb2]", imu.accel_bias_mps2,
                    imu.accel_bias_sigma_mps2, 1e3, 1));
  return out;
}

}  // namespace

std::optional<ReportSection> ImuSection(const Estimate& estimate) {
  ReportSection out;
  out.title = "IMU";
  if (!estimate.imu) {
    const auto reason = WhyImuIsLeftOut(estimate.warnings);
    if (!reason) return std::nullopt;
    out.html = ParagraphHtml("Left out: " + *reason + ".");
    return out;
  }
  const ImuResult& imu = *estimate.imu;
  out.html = ParagraphHtml(Format(
      "In the estimate, over %d intervals between frames. Its clock is %+.3f \xc2\xb1 %.3f "
      "ms ahead of the stamps; gravity's direction is known to %.2f mrad; noise %.2g rad/s "
      "and %.2g m/s\xc2\xb2 per root Hz. Biases are those at the middle of the recording; all "
      "with standard deviations.",
      imu.intervals, 1e3 * imu.time_offset_s, 1e3 * imu.time_offset_sigma_s,
      1e3 * imu.gravity_sigma_rad, imu.gyro_noise, imu.accel_noise));
  out.html += TableHtml(Found(imu));
  return out;
}

}  // namespace tagtwist::internal
