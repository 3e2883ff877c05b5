#include "estimator/evaluation/hand_eye.h"

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "estimator/calibration/solver.h"
#include "frontend/types/truth.h"

namespace tagtwist::internal {
namespace {

// Wide enough to say nothing where the motion says anything.
constexpr double kPositionSigmaM = 10, kRotationSigmaRad = 3, kClockSigmaS = 1;
constexpr double kClockReachS = 0.05;  // from a start's clock; as far there is truth at hand
constexpr size_t kLeastFrames = 3;

CalibrationProblem ProblemFrom(const PoseSeries& series, const std::vector<TruthSample>& truth,
                               const Alignment& start, const AlignmentOptions& options) {
  CalibrationProblem out;
  out.prior.cam_from_body = start.body_from_marker;
  out.prior.truth_from_world = start.truth_from_world;
  out.prior.time_offset_s = start.time_offset_s;
  out.truth = truth;
  out.max_truth_gap_s = options.max_truth_gap_s;
  const CalibrationLayout layout = LayoutOf(out.prior);
  out.prior_sigmas.setZero(layout.size());
  for (const int first : {layout.mount(), layout.world()}) {
    out.prior_sigmas.segment<3>(first).setConstant(kRotationSigmaRad);
    out.prior_sigmas.segment<3>(first + 3).setConstant(kPositionSigmaM);
  }
  if (options.estimate_time_offset) out.prior_sigmas(layout.clock()) = kClockSigmaS;
  const int64_t offset_ns = std::llround(1e9 * start.time_offset_s);
  const double reach_s = options.estimate_time_offset ? kClockReachS : 0;
  const auto no_views = std::make_shared<const std::vector<CalibrationView>>();
  for (const PoseSample& sample : series) {
    CalibrationFrame frame;
    frame.t_ns = sample.t_ns;
    frame.world_from_cam = sample.world_from_body;
    frame.pose_known = frame.has_truth = true;
    frame.shared_views = no_views;
    if (HasTruthAround(truth, frame.t_ns + offset_ns, reach_s, options.max_truth_gap_s)) {
      out.frames.push_back(std::move(frame));
    }
  }
  return out;
}

// By least squares, the misfits weighed as a calibration begins with.
CalibrationSolution PlainFit(CalibrationProblem problem) {
  problem.robust_scale = std::numeric_limits<double>::infinity();
  return SolveCalibration(problem, problem.prior, CalibrationNoise());
}

Alignment AlignmentOf(const CalibrationSolution& solution) {
  const CalibrationLayout layout = LayoutOf(solution.state);
  const Eigen::VectorXd sigmas = solution.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  Alignment out;
  out.truth_from_world = solution.state.truth_from_world;
  out.body_from_marker = solution.state.cam_from_body;
  out.time_offset_s = solution.state.time_offset_s;
  out.sigmas = AlignmentSigmas{sigmas.segment<6>(layout.world()), sigmas.segment<6>(layout.mount()),
                               sigmas(layout.clock())};
  return out;
}

}  // namespace

Result<Alignment> AlignHandEye(const PoseSeries& series, const std::vector<TruthSample>& truth,
                               const std::vector<Alignment>& starts,
                               const AlignmentOptions& options) {
  CalibrationProblem problem;
  CalibrationSolution best;
  for (const Alignment& start : starts) {
    CalibrationProblem from = ProblemFrom(series, truth, start, options);
    if (from.frames.size() < kLeastFrames) {
      return Error{"hand-eye alignment needs at least 3 poses with ground truth at hand, got " +
                   std::to_string(from.frames.size())};
    }
    CalibrationSolution fit = PlainFit(from);
    if (!fit.usable || (best.usable && !(fit.cost < best.cost))) continue;
    problem = std::move(from);
    best = std::move(fit);
  }
  if (best.usable) best = SolveAndLearnNoise(problem, best.state, CalibrationNoise(), false);
  if (!best.usable) return Error{"hand-eye alignment has no solution"};
  return AlignmentOf(best);
}

}  // namespace tagtwist::internal
