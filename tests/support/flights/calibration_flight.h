#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "estimator/calibration/calibration.h"
#include "estimator/calibration/problem.h"
#include "estimator/online/calibration_input.h"
#include "estimator/online/config.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// How the body moves over the mat.
enum class CalibrationMotion {
  kFree,            // turns about all axes, climbs and sinks
  kNoRotation,      // upright, its heading fixed
  kConstantHeight,  // turns about the vertical alone, at one height
};

struct CalibrationFlightOptions {
  CalibrationMotion motion = CalibrationMotion::kFree;
  bool errors = true;         // false: the configuration is right, but for the tags
  int rows = 7, columns = 6;  // of the mat; as the course's otherwise
  int frames = 300;
  double rate_hz = 25;
  double corner_sigma_px = 0.15;
  double truth_position_sigma_m = 0.0005, truth_rotation_sigma_rad = 0.001;
  double line_time_s = 0;  // of the shutter; not what is believed
  double tag_position_sigma_m = 0.005, tag_rotation_sigma_rad = 0.01;  // an axis
  double tag_bend_sigma = 0;                                           // in sides
  unsigned random_seed = 1;
};

/// A flight by a set-up that is not as configured: focal length, principal point, two distortion
/// terms, mount, print scale, clock, and every tag's place and bend. Corners and ground truth with
/// Gaussian noise.
struct CalibrationFlight {
  Config config;  // what is believed; the tags' priors are what they were drawn from
  CalibrationState truth;
  std::vector<FrameMeasurements> measurements;
  std::vector<Pose> world_from_body;      // of every frame, exact
  std::vector<TruthSample> ground_truth;  // at 200 Hz
};

CalibrationFlight DrawCalibrationFlight(const CalibrationFlightOptions& options);

/// Whether one of the lines has that part.
inline bool Says(const std::vector<std::string>& lines, const std::string& part) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

/// Of frames not fitted to, where the group was applied; else 0.
inline double Gain(const Calibration& calibration, CalibrationGroup group) {
  for (const GroupVerdict& verdict : calibration.validation.verdicts) {
    if (verdict.group == group) return verdict.applied ? verdict.gain : 0;
  }
  return 0;
}

constexpr double kBendSigma = 0.007;  // in sides, 1.06 mm

/// Few frames and tags: every calibration is twenty and more searches.
inline CalibrationFlightOptions ShortFlight() {
  CalibrationFlightOptions options;
  options.rows = 4;
  options.columns = 4;
  options.frames = 80;
  options.rate_hz = 7;  // between the samples of the ground truth, not on them
  return options;
}

}  // namespace tagtwist::internal
