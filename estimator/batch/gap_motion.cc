#include "estimator/batch/gap_motion.h"

#include <algorithm>

#include "estimator/graph/linear_system.h"
#include "residuals/motion_residual.h"

namespace tagtwist::internal {
namespace {

// Which frames a gap lies before or which are its bridges.
std::vector<bool> FramesInGaps(const std::vector<FrameRange>& gaps, size_t n) {
  std::vector<bool> out(n, false);
  for (const FrameRange& gap : gaps) {
    for (int k = gap.first + 1; k <= gap.last; ++k) out[static_cast<size_t>(k)] = true;
  }
  return out;
}

MotionScale MotionBeside(const std::vector<bool>& in_gap, const FrameRange& gap,
                         const std::vector<GraphFrame>& frames) {
  constexpr int kFrames = 5;
  MotionScale out{0, 0};
  const int last = std::min(gap.last + kFrames, static_cast<int>(frames.size()) - 1);
  for (int k = std::max(1, gap.first - kFrames); k <= last; ++k) {
    if (in_gap[static_cast<size_t>(k)]) continue;
    const MotionScale& there = frames[static_cast<size_t>(k)].motion;
    out = {std::max(out.linear, there.linear), std::max(out.angular, there.angular)};
  }
  return out.linear > 0 ? out : MotionScale();
}

// From one frame to a later one: the mean density, and how far the body turned in all.
struct Window {
  MotionScale motion{0, 0};
  double turn_rad = 0;
};

Window WindowOver(const std::vector<GraphFrame>& frames, size_t first, size_t last) {
  Window out;
  for (size_t k = first + 1; k <= last; ++k) {
    const double share = static_cast<double>(frames[k].t_ns - frames[k - 1].t_ns) /
                         static_cast<double>(frames[last].t_ns - frames[first].t_ns);
    out.motion.linear += share * frames[k].motion.linear;
    out.motion.angular += share * frames[k].motion.angular;
    out.turn_rad +=
        AngleBetween(frames[k - 1].state.world_from_body, frames[k].state.world_from_body);
  }
  return out;
}

// Adds e' Q^-1 e of the motion from one frame to the other.
void AddWindow(const NoiseModel& noise, const std::vector<GraphFrame>& frames, size_t first,
               size_t last, GapMotion* out) {
  constexpr double kMostTurnRad = 2.5;  // where the prior holds
  const Window window = WindowOver(frames, first, last);
  const auto state = [&](size_t k) {
    return ToGraphState(frames[k].t_ns, frames[k].state, frames[k].acceleration);
  };
  const GraphState a = state(first), b = state(last);
  const MotionResidual residual(
      ToSeconds(b.t_ns - a.t_ns),
      WithDensity(noise.linear, window.motion.linear * noise.linear.psd),
      WithDensity(noise.angular, window.motion.angular * noise.angular.psd));
  const double* parameters[] = {a.pose.params.data(), a.rates.data(), b.pose.params.data(),
                                b.rates.data()};
  Eigen::Matrix<double, 18, 1> r;
  residual.Evaluate(parameters, r.data(), nullptr);
  const auto dof = [](WhiteNoiseOn on) { return on == WhiteNoiseOn::kJerk ? 9.0 : 6.0; };
  out->linear +=
      {r.segment<9>(MotionResidual::kLinear.first_row).squaredNorm(), dof(noise.linear.on)};
  if (window.turn_rad > kMostTurnRad) return;
  out->angular +=
      {r.segment<9>(MotionResidual::kAngular.first_row).squaredNorm(), dof(noise.angular.on)};
}

// Of what the motion has over that time, from frames that see tags to such frames.
GapMotion MotionOverTime(double dt_s, const NoiseModel& noise,
                         const std::vector<GraphFrame>& frames) {
  constexpr size_t kWindows = 40;
  GapMotion out;
  const size_t step = std::max<size_t>(1, frames.size() / kWindows);
  for (size_t k = 0; k < frames.size(); k += step) {
    const auto end = std::upper_bound(
        frames.begin(), frames.end(), frames[k].t_ns + static_cast<int64_t>(1e9 * dt_s),
        [](int64_t t_ns, const GraphFrame& frame) { return t_ns < frame.t_ns; });
    const auto last = static_cast<size_t>(end - frames.begin()) - 1;
    if (end == frames.end() || last == k) continue;
    if (ToSeconds(frames[last].t_ns - frames[k].t_ns) < 0.8 * dt_s) continue;
    if (frames[k].tags.empty() || frames[last].tags.empty()) continue;
    AddWindow(noise, frames, k, last, &out);
  }
  return out;
}

// By what the density is larger over that time, or over a half or a quarter of it: of the longest
// the recording may show little. Over less than half a second the learned density holds.
MotionScale GrowthOver(double dt_s, const NoiseModel& noise,
                       const std::vector<GraphFrame>& frames) {
  constexpr double kLeastS = 0.5, kLeastGrowth = 1.3;
  constexpr double kLeastDof = 45;  // five windows
  MotionScale out;
  const auto take = [](const VarianceStatistic& statistic, double* part) {
    if (statistic.dof < kLeastDof) return;
    const double ratio = statistic.sum / statistic.dof;
    if (ratio > kLeastGrowth) *part = std::max(*part, ratio);
  };
  for (const double share : {1.0, 0.5, 0.25}) {
    if (share * dt_s < kLeastS) break;
    const GapMotion motion = MotionOverTime(share * dt_s, noise, frames);
    take(motion.linear, &out.linear);
    take(motion.angular, &out.angular);
  }
  return out;
}

}  // namespace

GapMotion MotionOver(const FrameRange& gap, const NoiseModel& noise, const Solution& solution) {
  NoiseStatistics sums;
  LinearFactor linear;
  for (const Factor& factor : solution.graph.factors) {
    if (factor.kind != FactorKind::kMotion) continue;
    const int k = factor.blocks.front().index;
    if (k < gap.first || k >= gap.last) continue;
    if (!LinearizeFactor(solution.graph, factor, &linear)) continue;
    const std::vector<GraphState>& states = solution.graph.states;
    const auto first = static_cast<size_t>(k);
    const double dt_s = ToSeconds(states[first + 1].t_ns - states[first].t_ns);
    AddMotionStatistic(linear, solution.covariance, {k, dt_s, false}, noise, &sums);
  }
  GapMotion out{sums.linear, sums.angular};
  out.linear.sum /= noise.linear.psd;
  out.angular.sum /= noise.angular.psd;
  return out;
}

void SetMotion(const FrameRange& gap, const MotionScale& motion, std::vector<GraphFrame>* frames) {
  for (int k = gap.first + 1; k <= gap.last; ++k) (*frames)[static_cast<size_t>(k)].motion = motion;
}

MotionScale ExpectedMotion(const std::vector<FrameRange>& gaps, const FrameRange& gap,
                           const NoiseModel& noise, const std::vector<GraphFrame>& frames) {
  const MotionScale beside = MotionBeside(FramesInGaps(gaps, frames.size()), gap, frames);
  const double dt_s = ToSeconds(frames[static_cast<size_t>(gap.last)].t_ns -
                                frames[static_cast<size_t>(gap.first)].t_ns);
  const MotionScale growth = GrowthOver(dt_s, noise, frames);
  return {beside.linear * growth.linear, beside.angular * growth.angular};
}

}  // namespace tagtwist::internal
