#include "estimator/calibration/costs.h"

#include <cmath>
#include <utility>

#include "frontend/base/least_squares.h"
#include "frontend/base/statistics/robust.h"
#include "frontend/types/truth.h"
#include "residuals/truth_residual.h"

namespace tagtwist::internal {

std::optional<WhitenedTruth> LinearizeTruth(const CalibrationProblem& problem,
                                            const CalibrationState& state,
                                            const CalibrationFrame& frame,
                                            const CalibrationNoise& noise) {
  const int64_t t_ns = frame.t_ns + std::llround(1e9 * state.time_offset_s);
  const auto truth = InterpolateTruth(problem.truth, t_ns, problem.max_truth_gap_s);
  if (!truth) return std::nullopt;
  const Twist rate =
      DifferentiateTruth(problem.truth, t_ns, problem.max_truth_gap_s).value_or(Twist());
  const TruthResidual at = EvaluateTruth(truth->world_from_body, rate, state.truth_from_world,
                                         frame.world_from_cam, state.cam_from_body);
  Eigen::Matrix<double, 6, 1> weights;
  weights.head<3>().setConstant(
      1 / (noise.truth_rotation_sigma_rad * noise.truth_rotation_persistence));
  weights.tail<3>().setConstant(1 /
                                (noise.truth_position_sigma_m * noise.truth_position_persistence));
  WhitenedTruth out;
  out.residual = weights.asDiagonal() * at.residual;
  out.by_cam = weights.asDiagonal() * at.by_cam;
  out.by_shared << at.by_mount, at.by_world, at.by_offset;
  out.by_shared = weights.asDiagonal() * out.by_shared;
  return out;
}

bool LinearizeView(const CalibrationState& state, const CalibrationFrame& frame,
                   const CalibrationView& view, TagCalibrationResidual* out, bool shared) {
  const RollingShutter shutter{state.line_time_s, frame.motion.value_or(Twist())};
  return EvaluateTagCalibration(state.tags[static_cast<size_t>(view.tag)],
                                std::exp(state.log_scale), state.camera, frame.world_from_cam,
                                view.pixels, view.whitener, shutter, out, shared);
}

std::optional<QuadraticForm<6>> LinearizePose(const CalibrationProblem& problem,
                                              const CalibrationState& state,
                                              const CalibrationFrame& frame,
                                              const CalibrationNoise& noise) {
  QuadraticForm<6> out;
  TagCalibrationResidual at;
  for (const CalibrationView& view : frame.views()) {
    if (!LinearizeView(state, frame, view, &at, false)) return std::nullopt;
    const RobustLoss loss = Huber(at.residual.squaredNorm(), HuberDelta(problem.robust_scale, 8));
    out.Add(at.by_cam, at.residual, loss.cost, loss.weight);
  }
  if (!frame.has_truth) return out;
  const auto truth = LinearizeTruth(problem, state, frame, noise);
  if (!truth) return std::nullopt;
  const RobustLoss loss = Huber(truth->residual.squaredNorm(), HuberDelta(problem.robust_scale, 6));
  out.Add(truth->by_cam, truth->residual, loss.cost, loss.weight);
  return out;
}

namespace {

// A frame's pose, the shared parameters known.
struct PoseOfFrame {
  using State = CalibrationFrame;
  using Normals = QuadraticForm<6>;

  const CalibrationProblem& problem;
  const CalibrationState& state;
  const CalibrationNoise& noise;

  std::optional<Normals> Linearise(const CalibrationFrame& frame) const {
    return LinearizePose(problem, state, frame, noise);
  }
  std::optional<LeastSquaresStep<PoseStep>> Solve(const CalibrationFrame&, double damping,
                                                  Normals* normals) const {
    Normals ridged = *normals;
    ridged.hessian.diagonal().array() += kPoseRidge;
    return DampedStep(ridged, damping);
  }
  CalibrationFrame Step(CalibrationFrame frame, const PoseStep& dx) const {
    frame.world_from_cam = Retract(frame.world_from_cam, dx);
    return frame;
  }
};

}  // namespace

std::optional<double> AdjustPose(const CalibrationProblem& problem, const CalibrationState& state,
                                 const CalibrationNoise& noise, CalibrationFrame* frame) {
  LeastSquaresOptions options;
  options.max_steps = 50;
  options.first_damping = 1e-6;
  options.absolute_tolerance = 1e-6;
  PoseOfFrame pose{problem, state, noise};
  auto found = SolveLeastSquares(pose, *frame, options);
  if (found.end == LeastSquaresEnd::kNotEvaluable) return std::nullopt;
  *frame = std::move(found.x);
  return found.cost;
}

}  // namespace tagtwist::internal
