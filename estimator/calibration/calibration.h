#pragma once
#include <string>
#include <vector>

#include "estimator/calibration/observability.h"
#include "estimator/calibration/options.h"
#include "estimator/calibration/problem.h"
#include "estimator/calibration/validation.h"
#include "estimator/graph/estimator_options.h"
#include "frontend/base/result.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {

/// What a calibration starts from.
struct CalibrationInput {
  SetUp set_up;
  EstimatorOptions estimator;
  CalibrationOptions options;
  int least_frames = 20;                    // with tags; fewer are an error
  std::vector<CalibrationGroup> kept = {};  // refined, whatever they help frames left out
};

/// The set-up as the data have it. Vectors and matrices over the error state, full layout.
struct Calibration {
  SetUp set_up;  // refined; its map in the ground truth's world where there is one
  CalibrationState given, refined;
  std::vector<CalibrationParameter> parameters;
  Eigen::VectorXd prior_sigmas;  // 0: held, or nothing is seen of it
  std::vector<bool> applied;     // refined; the others stay as given
  Eigen::VectorXd change;        // refined as seen from given
  /// Zero where held. Where groups are not applied it is the second moment about the refined state
  /// of what a solution with all of them free says.
  Eigen::MatrixXd covariance;
  CalibrationNoise noise;
  CalibrationValidation validation;
  std::vector<UnseenDirection> unseen;  // of everything that is not held, applied or not
  int frames = 0, views = 0;
  bool has_truth = false;

  double sigma(int entry) const { return std::sqrt(covariance(entry, entry)); }
};

/// Refines the configured set-up by the tags of a recording and, where there is any, by ground
/// truth (body in W). Frames' poses are free. A group of parameters that does not help frames that
/// it was not fitted to stays as configured (validation.h). An error when there are too
/// few frames, or no solution.
Result<Calibration> Calibrate(const CalibrationInput& input,
                              const std::vector<FrameMeasurements>& measurements,
                              const std::vector<TruthSample>& truth);

/// That state as a set-up; its map lies in the ground truth's world.
SetUp Apply(const SetUp& set_up, const CalibrationState& state);

/// The problem that Calibrate solves, all parameters free that the options leave free and something
/// is seen of.
Result<CalibrationProblem> MakeCalibrationProblem(
    const CalibrationInput& input, const std::vector<FrameMeasurements>& measurements,
    const std::vector<TruthSample>& truth);

}  // namespace tagtwist::internal
