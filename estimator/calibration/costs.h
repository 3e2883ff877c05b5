#pragma once
#include <Eigen/Core>
#include <optional>

#include "estimator/calibration/problem.h"
#include "frontend/base/quadratic_form.h"
#include "residuals/tag_calibration_residual.h"

namespace tagtwist::internal {

constexpr int kTruthColumns = 13;  // mount, world, clock

/// A frame against the ground truth (truth_residual.h), whitened.
struct WhitenedTruth {
  Eigen::Matrix<double, 6, 1> residual;
  Eigen::Matrix<double, 6, 6> by_cam;
  Eigen::Matrix<double, 6, kTruthColumns> by_shared;
};
/// nullopt where the ground truth says nothing.
std::optional<WhitenedTruth> LinearizeTruth(const CalibrationProblem& problem,
                                            const CalibrationState& state,
                                            const CalibrationFrame& frame,
                                            const CalibrationNoise& noise);

/// A view's whitened residual and its derivatives, without `shared` only by the camera's pose.
/// False where it cannot be evaluated.
bool LinearizeView(const CalibrationState& state, const CalibrationFrame& frame,
                   const CalibrationView& view, TagCalibrationResidual* out, bool shared);

constexpr double kPoseRidge = 1e-9;  // added to the information of a pose that its tags leave open

/// A frame's own measurements as a form in its pose, robust, the shared parameters known. nullopt
/// where they cannot be evaluated.
std::optional<QuadraticForm<6>> LinearizePose(const CalibrationProblem& problem,
                                              const CalibrationState& state,
                                              const CalibrationFrame& frame,
                                              const CalibrationNoise& noise);

/// Refines a frame's pose, the shared parameters known, by Levenberg-Marquardt; its cost there.
/// nullopt, the frame unchanged, where its measurements cannot be evaluated.
std::optional<double> AdjustPose(const CalibrationProblem& problem, const CalibrationState& state,
                                 const CalibrationNoise& noise, CalibrationFrame* frame);

}  // namespace tagtwist::internal
