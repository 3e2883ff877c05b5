#include "estimator/batch/gaps.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "frontend/base/statistics/quantile.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

constexpr double kPi = 3.14159265358979323846;
// A turn that may as well have been the other way round: that is less than four times as long.
constexpr double kOpenTurnRad = 1.3;

const GraphFrame& At(const std::vector<GraphFrame>& frames, int k) {
  return frames[static_cast<size_t>(k)];
}

double SecondsBetween(const GraphFrame& first, const GraphFrame& second) {
  return ToSeconds(second.t_ns - first.t_ns);
}

Eigen::Vector3d TurnBetween(const GraphFrame& first, const GraphFrame& second) {
  return Difference(second.state.world_from_body, first.state.world_from_body).head<3>();
}

// The rate beside a gap, from the poses: over a few frames from frame k on, in that direction.
// Zero where these are not close together.
Eigen::Vector3d RateBeside(const std::vector<GraphFrame>& frames, int k, int direction,
                           double longest_s) {
  constexpr int kFrames = 4;
  int other = k;
  for (int i = 0; i < kFrames; ++i) {
    const int next = other + direction;
    if (next < 0 || next >= static_cast<int>(frames.size())) break;
    if (std::abs(SecondsBetween(At(frames, other), At(frames, next))) > longest_s) break;
    other = next;
  }
  if (other == k) return Eigen::Vector3d::Zero();
  const int first = std::min(k, other), last = std::max(k, other);
  return TurnBetween(At(frames, first), At(frames, last)) /
         SecondsBetween(At(frames, first), At(frames, last));
}

// By the rates on both sides. Where one side has none the other's counts.
Eigen::Vector3d ExpectedTurn(const std::vector<GraphFrame>& frames, const FrameRange& gap,
                             double longest_s) {
  const Eigen::Vector3d before = RateBeside(frames, gap.first, -1, longest_s),
                        after = RateBeside(frames, gap.last, 1, longest_s);
  const double sides = (before.isZero() ? 0 : 1) + (after.isZero() ? 0 : 1);
  if (sides == 0) return Eigen::Vector3d::Zero();
  return SecondsBetween(At(frames, gap.first), At(frames, gap.last)) / sides * (before + after);
}

// What the motion adds to a turn whose rates at both ends are known: a standard deviation.
double OpenTurnSigma(const MotionPrior& angular, double dt_s) {
  const double of_acceleration = std::pow(dt_s, 3) / 12;
  if (angular.on == WhiteNoiseOn::kAcceleration) return std::sqrt(angular.psd * of_acceleration);
  return std::sqrt(angular.psd *
                   (std::pow(dt_s, 5) / 720 + angular.shake_s * angular.shake_s * of_acceleration));
}

// Whether the body may have turned another way.
bool IsOpen(const Eigen::Vector3d& rest, const Eigen::Vector3d& expected, double sigma_rad,
            double dt_s) {
  constexpr double kFastest = 12;  // rad/s that the long way round may take in the mean
  if (std::max({rest.norm(), expected.norm(), 2 * sigma_rad}) > kOpenTurnRad) return true;
  return IsUnexpected(rest, expected) && 2 * kPi - rest.norm() < kFastest * dt_s;
}

// The intervals that are four times as long as most, and a tenth of a second.
double LeastGapS(const std::vector<GraphFrame>& frames) {
  constexpr double kTimesUsual = 4, kLeastS = 0.1;
  std::vector<double> intervals_s;
  for (size_t k = 1; k < frames.size(); ++k) {
    intervals_s.push_back(SecondsBetween(frames[k - 1], frames[k]));
  }
  return std::max(kLeastS, kTimesUsual * Quantile(std::move(intervals_s), 0.5));
}

// For that way there and one more turn either way, turns between states of less than 0.8 rad.
int BridgesFor(double turn_rad) {
  constexpr double kStepRad = 0.8, kMost = 200;
  return static_cast<int>(std::min(kMost, std::ceil((turn_rad + 2 * kPi) / kStepRad)));
}

std::vector<GraphFrame> Bridges(const GraphFrame& first, const GraphFrame& last, int n) {
  std::vector<GraphFrame> out(static_cast<size_t>(n));
  for (int i = 0; i < n; ++i) {
    GraphFrame& bridge = out[static_cast<size_t>(i)];
    bridge.t_ns =
        first.t_ns + static_cast<int64_t>(std::llround(static_cast<double>(last.t_ns - first.t_ns) *
                                                       (i + 1) / (n + 1)));
    bridge.motion = last.motion;
  }
  return out;
}

bool IsTied(const GraphInput& input, int k) {
  return std::any_of(input.segments.begin(), input.segments.end(), [&](const TrackSegment& s) {
    return s.first_frame - input.first_frame <= k && s.last_frame() - input.first_frame > k;
  });
}

Eigen::Vector3d WholeTurns(const Eigen::Vector3d& axis, double turn_rad) {
  return 2 * kPi * std::round(turn_rad / (2 * kPi)) * axis;
}

// Where new states stand among the old ones: how many before each.
void CountAnew(const std::vector<int>& shifts, std::vector<int>* state_of_frame,
               GraphInput* input) {
  for (int& state : *state_of_frame) {
    if (state >= 0) state += shifts[static_cast<size_t>(state)];
  }
  for (TrackSegment& segment : input->segments) {
    segment.first_frame += shifts[static_cast<size_t>(segment.first_frame - input->first_frame)];
  }
}

}  // namespace

std::vector<FrameRange> FindAndBridgeGaps(const NoiseModel& noise, std::vector<int>* state_of_frame,
                                          GraphInput* input) {
  std::vector<FrameRange> gaps;
  const std::vector<GraphFrame>& old = input->frames;
  if (old.size() < 3) return gaps;
  const double least_s = LeastGapS(old), beside_s = std::min(least_s, 0.3);
  const auto next_gap = std::adjacent_find(
      old.begin(), old.end(),
      [&](const GraphFrame& a, const GraphFrame& b) { return SecondsBetween(a, b) >= least_s; });
  if (next_gap == old.end()) return gaps;  // of long recordings a copy would be a lot to hold
  std::vector<GraphFrame> frames;
  std::vector<int> shifts;
  std::vector<std::pair<FrameRange, GapTurn>> bridged;
  for (int k = 0; k < static_cast<int>(old.size()); ++k) {
    const int added = static_cast<int>(frames.size()) - k;
    const bool is_gap = k > 0 && SecondsBetween(At(old, k - 1), At(old, k)) >= least_s;
    if (is_gap && !IsTied(*input, k - 1)) {
      FrameRange gap{k - 1 + added, k + added};
      const Eigen::Vector3d rest = TurnBetween(At(old, k - 1), At(old, k)),
                            expected = ExpectedTurn(old, {k - 1, k}, beside_s);
      const double dt_s = SecondsBetween(At(old, k - 1), At(old, k));
      if (IsOpen(rest, expected, OpenTurnSigma(noise.angular, dt_s), dt_s)) {
        const Eigen::Vector3d axis = (rest.norm() > 0.5 ? rest : expected).normalized();
        const GapTurn turn{WholeTurns(axis, axis.dot(expected - rest)), rest};
        auto between =
            Bridges(At(old, k - 1), At(old, k), BridgesFor((turn.whole + turn.rest).norm()));
        std::move(between.begin(), between.end(), std::back_inserter(frames));
        gap.last += static_cast<int>(between.size());
        bridged.push_back({gap, turn});
      }
      gaps.push_back(gap);
    }
    shifts.push_back(static_cast<int>(frames.size()) - k);
    frames.push_back(old[static_cast<size_t>(k)]);
  }
  if (bridged.empty()) return gaps;
  CountAnew(shifts, state_of_frame, input);
  input->frames = std::move(frames);
  for (const auto& [gap, turn] : bridged) LayBridges(turn, gap, &input->frames);
  return gaps;
}

GapTurn TurnThrough(const std::vector<GraphFrame>& frames, const FrameRange& gap) {
  GapTurn out;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  // about one axis but for small parts
  for (int k = gap.first; k < gap.last; ++k) {
    sum += TurnBetween(At(frames, k), At(frames, k + 1));
  }
  out.rest = TurnBetween(At(frames, gap.first), At(frames, gap.last));
  const Eigen::Vector3d more = sum - out.rest;
  if (more.norm() > kPi) out.whole = WholeTurns(more.normalized(), more.norm());
  return out;
}

GapTurn TurnedOn(const std::vector<GraphFrame>& frames, const FrameRange& gap, const GapTurn& turn,
                 int whole_turns) {
  Eigen::Vector3d axis = turn.rest;
  if (!(axis.norm() > 0.5)) {
    axis =
        At(frames, gap.first).state.twist.omega_body + At(frames, gap.last).state.twist.omega_body;
  }
  if (turn.whole.norm() > 1) axis = turn.whole.dot(axis) < 0 ? -turn.whole : turn.whole;
  if (!(axis.norm() > 1e-6)) axis = Eigen::Vector3d::UnitZ();
  return {turn.whole + 2 * kPi * whole_turns * axis.normalized(), turn.rest};
}

void LayBridges(const GapTurn& turn, const FrameRange& gap, std::vector<GraphFrame>* frames) {
  const GraphFrame first = At(*frames, gap.first), last = At(*frames, gap.last);
  const double dt_s = SecondsBetween(first, last);
  const Eigen::Vector3d way =
      last.state.world_from_body.translation() - first.state.world_from_body.translation();
  for (int k = gap.first + 1; k < gap.last; ++k) {
    GraphFrame& bridge = (*frames)[static_cast<size_t>(k)];
    const double f = SecondsBetween(first, bridge) / dt_s;
    bridge.state.world_from_body = MakePose(
        first.state.world_from_body.rotation() * ExpSo3(f * turn.whole) * ExpSo3(f * turn.rest),
        first.state.world_from_body.translation() + f * way);
    bridge.state.twist = {way / dt_s, (turn.whole + turn.rest) / dt_s};
    bridge.acceleration = {};
  }
}

}  // namespace tagtwist::internal
