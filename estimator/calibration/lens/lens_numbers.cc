#include "estimator/calibration/lens/lens_numbers.h"

#include "residuals/lens.h"

namespace tagtwist::internal {

std::vector<LensNumber> NumbersOf(const LensFound& found) {
  const Calibration& c = found.calibration;
  const RigCamera& mounted = c.set_up.rig.front();
  const Camera& camera = mounted.camera;
  const double inflation = found.inflation();
  const double focal = inflation * c.sigma(kLogFocal);
  std::vector<LensNumber> out = {{"fx", "px", camera.fx, focal * camera.fx},
                                 {"fy", "px", camera.fy, focal * camera.fy},
                                 {"cx", "px", camera.cx, inflation * c.sigma(kCentreX)},
                                 {"cy", "px", camera.cy, inflation * c.sigma(kCentreY)}};
  const Eigen::VectorXd coefficients = DistortionCoefficients(camera);
  int entry = kFirstDistortion;
  for (const std::string& name : DistortionNames(camera)) {
    const double value = coefficients(entry - kFirstDistortion);
    const double sigma = inflation * c.sigma(entry++);
    if (sigma > 0) out.push_back({name, "", value, sigma});  // the others were held
  }
  if (!found.besides.line_time) return out;
  const double sigma_s = inflation * c.sigma(LayoutOf(c.given).line_time());
  out.push_back({"line time", "us", 1e6 * mounted.line_time_s, 1e6 * sigma_s});
  return out;
}

}  // namespace tagtwist::internal
