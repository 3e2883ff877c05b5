#include "estimator/calibration/costs.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "frontend/base/robust.h"
#include "frontend/types/truth.h"
#include "residuals/truth_residual.h"

namespace tagtwist {

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

std::optional<PoseNormals> LinearizePose(const CalibrationProblem& problem,
                                         const CalibrationState& state,
                                         const CalibrationFrame& frame,
                                         const CalibrationNoise& noise) {
  PoseNormals out;
  TagCalibrationResidual at;
  for (const CalibrationView& view : frame.views()) {
    if (!LinearizeView(state, frame, view, &at, false)) return std::nullopt;
    const RobustLoss loss = Huber(at.residual.squaredNorm(), HuberDelta(problem.robust_scale, 8));
    out.cost += loss.cost;
    out.information += loss.weight * at.by_cam.transpose().lazyProduct(at.by_cam);
    out.gradient += loss.weight * at.by_cam.transpose().lazyProduct(at.residual);
  }
  if (!frame.has_truth) return out;
  const auto truth = LinearizeTruth(problem, state, frame, noise);
  if (!truth) return std::nullopt;
  const RobustLoss loss = Huber(truth->residual.squaredNorm(), HuberDelta(problem.robust_scale, 6));
  out.cost += loss.cost;
  out.information += loss.weight * truth->by_cam.transpose().lazyProduct(truth->by_cam);
  out.gradient += loss.weight * truth->by_cam.transpose().lazyProduct(truth->residual);
  return out;
}

std::optional<double> AdjustPose(const CalibrationProblem& problem, const CalibrationState& state,
                                 const CalibrationNoise& noise, CalibrationFrame* frame) {
  constexpr int kMaxSteps = 50;
  constexpr double kEnough = 1e-6, kMostDamping = 1e9;  // gain in half squares that ends the search
  auto normals = LinearizePose(problem, state, *frame, noise);
  if (!normals) return std::nullopt;
  double damping = 1e-6;
  for (int i = 0; i < kMaxSteps && damping < kMostDamping; ++i) {
    Eigen::Matrix<double, 6, 6> damped = normals->information;
    damped.diagonal() *= 1 + damping;
    damped.diagonal().array() += kPoseRidge;
    const Eigen::Matrix<double, 6, 1> step = damped.llt().solve(normals->gradient);
    if (0.5 * step.dot(normals->gradient) < kEnough) break;
    CalibrationFrame moved = *frame;
    moved.world_from_cam = Retract(frame->world_from_cam, -step);
    const auto there = LinearizePose(problem, state, moved, noise);
    if (there && there->cost <= normals->cost) {
      *frame = moved;
      normals = there;
      damping *= 0.1;
    } else {
      damping = std::max(1e-3, 10 * damping);
    }
  }
  return normals->cost;
}

}  // namespace tagtwist
