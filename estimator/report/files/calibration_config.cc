#include "estimator/report/files/calibration_config.h"

#include "estimator/calibration/sigmas.h"
#include "estimator/report/files/calibration_text.h"
#include "frontend/base/format_text.h"
#include "frontend/base/number_text.h"
#include "frontend/io/setup/camera_section.h"
#include "frontend/io/setup/tag_map_text.h"
#include "frontend/types/lens/lens.h"
#include "residuals/lens.h"

namespace tagtwist::internal {
namespace {

std::string Number(double value) { return FormatNumber(value); }

[[gnu::format(printf, 1, 0)]] std::string SigmaComment(const char* format, double sigma) {
  return sigma > 0 ? "  # +- " + Format(format, sigma) : "";
}

std::string MountText(const Calibration& c) {
  const int first = LayoutOf(c.given).mount();
  const Pose& pose = c.set_up.rig.front().cam_from_body;
  return "\ncam_from_body:\n  quaternion_xyzw: " + FormatNumberList(pose.params.head<4>()) +
         Format("  # +- %.2g %.2g %.2g rad", c.sigma(first), c.sigma(first + 1),
                c.sigma(first + 2)) +
         "\n  translation_m: " + FormatNumberList(pose.translation()) +
         Format("  # +- %.2g %.2g %.2g", c.sigma(first + 3), c.sigma(first + 4),
                c.sigma(first + 5)) +
         "\n" + MountSigmaLines(c.set_up.rig.front(), "  ");
}

std::string MapText(const Calibration& c) {
  const CalibrationLayout layout = LayoutOf(c.given);
  std::vector<std::string> notes;
  for (int i = 0; i < layout.n_tags; ++i) {
    const int first = layout.tag(i) + 3;
    notes.push_back(c.sigma(first) > 0 ? Format("+- %.1f %.1f %.1f mm", 1e3 * c.sigma(first),
                                                1e3 * c.sigma(first + 1), 1e3 * c.sigma(first + 2))
                                       : "as configured");
    const int bend = layout.bend(i);
    if (!c.applied[static_cast<size_t>(bend)]) continue;
    notes.back() += Format(", bend +- %.2f mm", 1e3 * c.sigma(bend));
  }
  std::string out = "\n" + FormatTagMap(c.set_up.map, notes);
  if (const auto sigma_m = TagSigmaOf(c)) {
    out.insert(out.find("  tags:\n"), "  sigma_m: " + Number(*sigma_m) + "\n");
  }
  return out;
}

}  // namespace

std::optional<double> TagSigmaOf(const Calibration& c) {
  const double tag_m = TagSigma(c.refined, {c.covariance, c.prior_sigmas, c.has_truth});
  if (tag_m > 0) return tag_m;
  return std::nullopt;
}

std::string CameraText(const Calibration& c, double inflation) {
  const Camera& camera = c.set_up.rig.front().camera;
  const double focal = inflation * c.sigma(kLogFocal);
  std::string out = "\ncamera:\n  width: " + std::to_string(camera.width) +
                    "\n  height: " + std::to_string(camera.height) + "\n";
  out += "  fx: " + Number(camera.fx) + SigmaComment("%.3g", focal * camera.fx) + "\n";
  out += "  fy: " + Number(camera.fy) + SigmaComment("%.3g", focal * camera.fy) + "\n";
  out += "  cx: " + Number(camera.cx) + SigmaComment("%.3g", inflation * c.sigma(kCentreX)) + "\n";
  out += "  cy: " + Number(camera.cy) + SigmaComment("%.3g", inflation * c.sigma(kCentreY)) + "\n";
  out += std::string("  distortion_model: ") + LensName(camera.lens) + "\n";
  out += "  distortion: " + FormatNumberList(DistortionCoefficients(camera));
  std::string sigmas;
  for (int i = kFirstDistortion; i < LensSize(camera); ++i)
    sigmas += Format(" %.2g", inflation * c.sigma(i));
  out += "  # +-" + sigmas + "\n";
  const double line_time_sigma_s = inflation * c.sigma(LayoutOf(c.given).line_time());
  const double line_time_s = c.set_up.rig.front().line_time_s;
  if (line_time_s != 0 || line_time_sigma_s > 0) {
    out += "  line_time_s: " + Number(line_time_s) + SigmaComment("%.2g", line_time_sigma_s) + "\n";
  }
  RigCamera known = c.set_up.rig.front();
  known.covariance *= inflation * inflation;
  return out + LensSigmaLines(known, "  ");
}

std::string FormatCalibrationConfig(const Calibration& c, const std::string& options) {
  std::string out =
      "# Refined by tagtwist_estimate --calibrate; +- is one standard deviation, 0 "
      "where a value was held.\n";
  for (const std::string& line : CalibrationText(c)) out += "# " + line + "\n";
  out += CameraText(c) + MountText(c) + MapText(c);
  return out + options;
}

}  // namespace tagtwist::internal
