#include "estimator/calibration/solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/calibration/costs.h"
#include "estimator/calibration/noise.h"
#include "estimator/calibration/normals.h"

namespace tagtwist::internal {

std::vector<int> FreeEntries(const Eigen::VectorXd& sigmas) {
  std::vector<int> out;
  for (Eigen::Index i = 0; i < sigmas.size(); ++i) {
    if (sigmas(i) > 0) out.push_back(static_cast<int>(i));
  }
  return out;
}

namespace {

// The step of the shared parameters, full layout.
Eigen::VectorXd SharedStep(const CalibrationNormals& normals, const std::vector<int>& free,
                           double damping) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(normals.gradient.size());
  if (free.empty()) return out;
  Eigen::MatrixXd damped = normals.information(free, free);
  damped.diagonal() *= 1 + damping;
  const Eigen::VectorXd gradient = normals.gradient(free);
  const Eigen::VectorXd step = damped.llt().solve(gradient);
  out(free) = -step;
  return out;
}

std::vector<CalibrationFrame> MoveFrames(std::vector<CalibrationFrame> frames,
                                         const CalibrationNormals& normals,
                                         const Eigen::VectorXd& shared_step) {
  for (size_t i = 0; i < frames.size(); ++i) {
    const EliminatedFrame& eliminated = normals.frames[i];
    const Eigen::VectorXd of_frame = shared_step(eliminated.columns);
    const Eigen::Matrix<double, 6, 1> step = -(eliminated.offset + eliminated.by_shared * of_frame);
    frames[i].world_from_cam = Retract(frames[i].world_from_cam, step);
  }
  return frames;
}

Eigen::MatrixXd SharedCovariance(const CalibrationNormals& normals, const std::vector<int>& free) {
  const Eigen::Index n = normals.gradient.size();
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(n, n);
  if (free.empty()) return out;
  const Eigen::MatrixXd information = normals.information(free, free);
  const auto size = static_cast<Eigen::Index>(free.size());
  const Eigen::MatrixXd inverse = information.llt().solve(Eigen::MatrixXd::Identity(size, size));
  out(free, free) = inverse;
  return out;
}

// The factor that a standard deviation is wrong by.
double Correction(double squares, double redundancy) {
  if (!(redundancy > 1)) return 1;
  return std::clamp(std::sqrt(squares / redundancy), 0.1, 10.0);
}

// How much greater errors count that follow each other with that correlation (first-order
// autoregression): sqrt((1 + r) / (1 - r)). 1 where the correlation may be chance.
double Persistence(double correlation, int frames) {
  const double chance = 2 / std::sqrt(3.0 * std::max(1, frames));
  if (!(correlation > chance)) return 1;
  const double r = std::min(correlation, 0.98);
  return std::sqrt((1 + r) / (1 - r));
}

// The poses alone.
CalibrationSolution SolvePoses(const CalibrationProblem& problem, CalibrationSolution out) {
  for (CalibrationFrame& frame : out.frames) {
    const auto cost = AdjustPose(problem, out.state, out.noise, &frame);
    if (!cost) return out;
    out.cost += *cost;
  }
  out.usable = true;
  return out;
}

// From where `out` is. `normals`: at the optimum, undamped.
CalibrationSolution Search(const CalibrationProblem& problem, const std::vector<int>& free,
                           CalibrationSolution out, CalibrationNormals* normals) {
  constexpr int kMaxIterations = 50;
  constexpr double kLeastDamping = 1e-3, kMostDamping = 1e9;  // once a step failed
  // Gain in half squares that ends the search: what is left moves nothing by a twentieth of its
  // sigma.
  constexpr double kTolerance = 1e-3;
  // Between samples of the ground truth the cost has kinks that the slope over 20 ms, which steps
  // are made from, does not know: a step that should have gained no more and did not is the last.
  constexpr double kKinks = 0.1;
  double damping = 0;
  const auto linearize = [&](const CalibrationState& state,
                             const std::vector<CalibrationFrame>& frames) {
    *normals = {};  // memory of the last ones first
    *normals = LinearizeCalibration(problem, state, frames, out.noise, damping);
  };
  linearize(out.state, out.frames);
  out.usable = normals->ok;
  while (out.usable && out.iterations < kMaxIterations && damping < kMostDamping) {
    const Eigen::VectorXd step = SharedStep(*normals, free, damping);
    const double cost = normals->cost,
                 gain = normals->pose_gain - 0.5 * normals->gradient.dot(step);
    if (!(gain * (1 + damping) > kTolerance)) break;
    ++out.iterations;
    CalibrationState state = Retract(out.state, step);
    std::vector<CalibrationFrame> frames = MoveFrames(out.frames, *normals, step);
    const double last_damping = std::exchange(damping, damping > kLeastDamping ? 0.1 * damping : 0);
    linearize(state, frames);
    if (normals->ok && normals->cost <= cost) {
      out.state = std::move(state);
      out.frames = std::move(frames);
    } else {
      damping = gain < kKinks ? 0 : std::max(kLeastDamping, 10 * last_damping);
      linearize(out.state, out.frames);
      if (gain < kKinks) break;
    }
  }
  if (out.usable && damping > 0) {
    damping = 0;
    linearize(out.state, out.frames);
  }
  out.cost = normals->cost;
  return out;
}

// With the normal equations at the optimum, for its covariance.
CalibrationSolution Solve(const CalibrationProblem& problem, const CalibrationState& start,
                          const CalibrationNoise& noise, CalibrationNormals* normals) {
  CalibrationSolution out;
  out.state = start;
  out.frames = problem.frames;
  out.noise = noise;
  const std::vector<int> free = FreeEntries(problem.prior_sigmas);
  if (!free.empty()) return Search(problem, free, std::move(out), normals);
  out = SolvePoses(problem, std::move(out));
  *normals = LinearizeCalibration(problem, out.state, out.frames, noise, 0);
  return out;
}

}  // namespace

CalibrationSolution SolveCalibration(const CalibrationProblem& problem,
                                     const CalibrationState& start, const CalibrationNoise& noise) {
  CalibrationNormals normals;
  return Solve(problem, start, noise, &normals);
}

CalibrationSolution SolveAndLearnNoise(const CalibrationProblem& problem,
                                       const CalibrationState& start,
                                       const CalibrationNoise& initial, bool learn_corners) {
  constexpr int kMaxRounds = 12;
  constexpr double kEnough = 0.01, kMinCornerPx = 1e-3, kMinTruth = 1e-5;
  CalibrationProblem weighted = problem;
  CalibrationNoise noise = initial;
  SetCornerNoise(noise.corner_sigma_px, &weighted.frames);
  CalibrationNormals normals;
  CalibrationSolution out = Solve(weighted, start, noise, &normals);
  for (int round = 0; out.usable; ++round) {
    out.covariance = SharedCovariance(normals, FreeEntries(problem.prior_sigmas));
    const NoiseSums sums =
        SumNoise(weighted, out.state, out.frames, noise, normals, out.covariance);
    const double corner = learn_corners ? Correction(sums.corner, sums.corner_redundancy) : 1;
    const double position = noise.truth_position_persistence *
                            Correction(sums.truth_position, sums.truth_position_redundancy);
    const double rotation = noise.truth_rotation_persistence *
                            Correction(sums.truth_rotation, sums.truth_rotation_redundancy);
    noise.corner_sigma_px = std::max(kMinCornerPx, corner * noise.corner_sigma_px);
    noise.truth_position_sigma_m = std::max(kMinTruth, position * noise.truth_position_sigma_m);
    noise.truth_rotation_sigma_rad = std::max(kMinTruth, rotation * noise.truth_rotation_sigma_rad);
    noise.truth_position_persistence =
        Persistence(sums.truth_position_correlation, sums.truth_frames);
    noise.truth_rotation_persistence =
        Persistence(sums.truth_rotation_correlation, sums.truth_frames);
    const double change = std::max(
        {std::abs(std::log(corner)), std::abs(std::log(position)), std::abs(std::log(rotation))});
    const bool enough = change < kEnough || noise.corner_sigma_px <= kMinCornerPx;
    if (enough || round == kMaxRounds) break;
    weighted.frames = std::move(out.frames);
    UpdateMotion(&weighted.frames);
    SetCornerNoise(noise.corner_sigma_px, &weighted.frames);
    const CalibrationState at = out.state;
    out = Solve(weighted, at, noise, &normals);
  }
  return out;
}

}  // namespace tagtwist::internal
