#include "estimator/calibration/validation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/calibration/costs.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/types/truth.h"

namespace tagtwist::internal {
namespace {

constexpr double kSigmaOfMad = 1.4826;
constexpr double kUnusableCost = 1e6;  // of a frame whose tags fall behind the camera

struct Samples {
  std::vector<double> corner_px, truth_m, truth_rad;
};

// The frame's pose by its tags alone, whatever the ground truth says.
void AddSamples(const CalibrationProblem& problem, const CalibrationState& state,
                const CalibrationNoise& noise, CalibrationFrame frame, Samples* out) {
  const bool has_truth = std::exchange(frame.has_truth, false);
  if (has_truth && !AdjustPose(problem, state, noise, &frame)) return;
  TagCalibrationResidual at;
  for (CalibrationView view : frame.views()) {
    view.whitener.setIdentity();
    if (!LinearizeView(state, frame, view, &at, false)) continue;
    for (const double error : at.residual) out->corner_px.push_back(std::abs(error));
  }
  if (!has_truth) return;
  const auto truth = InterpolateTruth(
      problem.truth, frame.t_ns + std::llround(1e9 * state.time_offset_s), problem.max_truth_gap_s);
  if (!truth) return;
  const Pose body = state.truth_from_world * frame.world_from_cam * state.cam_from_body;
  out->truth_m.push_back((body.translation() - truth->world_from_body.translation()).norm());
  out->truth_rad.push_back(AngleBetween(truth->world_from_body, body));
}

std::vector<CalibrationGroup> FreeGroups(const CalibrationProblem& problem,
                                         const std::vector<CalibrationParameter>& parameters) {
  std::vector<CalibrationGroup> out;
  for (const CalibrationGroup group : kAllCalibrationGroups) {
    bool free = false;
    for (size_t i = 0; i < parameters.size(); ++i) {
      free = free || (parameters[i].group == group &&
                      problem.prior_sigmas(static_cast<Eigen::Index>(i)) > 0);
    }
    if (free) out.push_back(group);
  }
  return out;
}

std::vector<CalibrationGroup> Without(std::vector<CalibrationGroup> groups,
                                      CalibrationGroup group) {
  groups.erase(std::remove(groups.begin(), groups.end(), group), groups.end());
  return groups;
}

// What `with` gains over `without` a block, and its standard error.
GroupVerdict Compare(CalibrationGroup group, const HeldOutJudgement& with,
                     const HeldOutJudgement& without) {
  const auto n = static_cast<double>(with.block_costs.size());
  double sum = 0, squares = 0;
  for (size_t i = 0; i < with.block_costs.size(); ++i) {
    const double gain = without.block_costs[i] - with.block_costs[i];
    sum += gain;
    squares += gain * gain;
  }
  const double mean = sum / n;
  const double variance = std::max(0.0, squares / n - mean * mean) * n / (n - 1);
  const double sigma = std::sqrt(variance / n);
  return {group, mean > 2 * sigma, mean, sigma};
}

}  // namespace

HeldOutJudgement JudgeHeldOut(const CalibrationProblem& problem,
                              const std::vector<CalibrationParameter>& parameters,
                              const std::vector<CalibrationGroup>& groups,
                              const CalibrationState& start, const CalibrationNoise& noise,
                              int n_blocks) {
  const size_t n = problem.frames.size();
  const size_t blocks = std::min(static_cast<size_t>(n_blocks), n);
  HeldOutJudgement out;
  out.block_costs.assign(blocks, 0);
  Samples samples;
  for (size_t fold = 0; fold < 2; ++fold) {
    std::vector<bool> fit(n), judge(n);
    for (size_t i = 0; i < n; ++i) fit[i] = (i * blocks / n) % 2 == fold;
    for (size_t i = 0; i < n; ++i) judge[i] = !fit[i];
    const CalibrationProblem fitted = Restrict(problem, parameters, groups, fit);
    const CalibrationState from = OnlyFree(start, fitted);
    const CalibrationState state =
        groups.empty() ? from : SolveCalibration(fitted, from, noise).state;
    for (size_t i = 0; i < n; ++i) {
      if (!judge[i]) continue;
      CalibrationFrame frame = problem.frames[i];
      out.block_costs[i * blocks / n] +=
          AdjustPose(problem, state, noise, &frame).value_or(kUnusableCost);
      AddSamples(problem, state, noise, frame, &samples);
    }
  }
  out.corner_sigma_px = kSigmaOfMad * Quantile(samples.corner_px, 0.5);
  if (!samples.truth_m.empty()) {
    out.truth_median_m = Quantile(samples.truth_m, 0.5);
    out.truth_median_rad = Quantile(samples.truth_rad, 0.5);
  }
  return out;
}

std::vector<CalibrationGroup> CalibrationValidation::applied() const {
  std::vector<CalibrationGroup> out;
  for (const GroupVerdict& verdict : verdicts) {
    if (verdict.applied) out.push_back(verdict.group);
  }
  return out;
}

CalibrationValidation ValidateGroups(const CalibrationProblem& problem,
                                     const std::vector<CalibrationParameter>& parameters,
                                     const CalibrationState& start, const CalibrationNoise& noise,
                                     int n_blocks, const std::vector<CalibrationGroup>& kept) {
  const auto judge = [&](const std::vector<CalibrationGroup>& groups) {
    return JudgeHeldOut(problem, parameters, groups, start, noise, n_blocks);
  };
  CalibrationValidation out;
  out.given = judge({});
  std::vector<CalibrationGroup> groups = FreeGroups(problem, parameters);
  std::vector<GroupVerdict> dropped;
  while (true) {
    out.refined = groups.empty() ? out.given : judge(groups);
    out.verdicts.clear();
    for (const CalibrationGroup group : groups) {
      if (std::count(kept.begin(), kept.end(), group) > 0) {
        out.verdicts.push_back({group, true, 0, 0});
        continue;
      }
      out.verdicts.push_back(Compare(group, out.refined, judge(Without(groups, group))));
    }
    const auto worst = std::min_element(
        out.verdicts.begin(), out.verdicts.end(), [](const auto& a, const auto& b) {
          return a.applied != b.applied ? b.applied : a.gain < b.gain;
        });
    if (worst == out.verdicts.end() || worst->applied) break;
    dropped.push_back(*worst);
    groups = Without(groups, worst->group);
  }
  out.verdicts.insert(out.verdicts.end(), dropped.begin(), dropped.end());
  return out;
}

}  // namespace tagtwist::internal
