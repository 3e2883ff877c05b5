#include <cmath>

#include "estimator/report/findings/findings.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

// RMS over the frames with a state of the position's standard deviation [m], 3-D.
double PositionSigma(const Estimate& estimate) {
  double sum = 0;
  size_t frames = 0;
  for (const FrameEstimate& f : estimate.frames) {
    if (f.status == FrameStatus::kNoFix) continue;
    sum += f.covariance.diagonal().segment<3>(3).sum();
    ++frames;
  }
  return frames > 0 ? std::sqrt(sum / static_cast<double>(frames)) : 0;
}

// Those that are worth mending, in words; empty where none is.
std::string Parts(const SystematicShare& s) {
  constexpr double kLeastPx = 0.05, kLeastM = 3e-4, kLeastRad = 3e-4;
  std::string out;
  const auto add = [&](const std::string& part) { out += (out.empty() ? "" : ", ") + part; };
  if (s.field_sigma_px > kLeastPx) {
    add(Format("%.2f px over the image beyond what the lens says", s.field_sigma_px));
  }
  if (s.mount_sigma_m > kLeastM || s.mount_sigma_rad > kLeastRad) {
    add(Format("%.1f mm and %.1f mrad of the cameras' mounts beside the first's",
               1e3 * s.mount_sigma_m, 1e3 * s.mount_sigma_rad));
  }
  if (s.tag_sigma_m > kLeastM) add(Format("%.1f mm of the tags' places", 1e3 * s.tag_sigma_m));
  if (s.bias_sigma_px > kLeastPx) {
    add(Format("%.2f px of all corners along their tags' diagonals", s.bias_sigma_px));
  }
  return out;
}

}  // namespace

std::vector<Finding> SystematicFindings(const Estimate& estimate) {
  constexpr double kMost = 0.5;  // of the variance
  const SystematicShare& s = estimate.systematic;
  const double sigma_m = PositionSigma(estimate);
  const std::string parts = Parts(s);
  if (parts.empty() || s.position_m * s.position_m < kMost * sigma_m * sigma_m) return {};
  return {{Format("Most of the uncertainty is of errors that last and that no number of frames "
                  "averages away (standard deviations): %s; %.1f mm of position.",
                  parts.c_str(), 1e3 * s.position_m),
           "The sigmas have it. --calibrate over a lively recording takes most of it off.", true}};
}

}  // namespace tagtwist::internal
