#include "estimator/batch/open_accounts.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/start/mirror.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

// Attitudes that lie further apart are open: 5 degrees.
constexpr double kOpenRad = 0.0873;
// Gain in the logarithm of a likelihood that is worth solving everything anew.
constexpr double kLikelier = 0.5;

// An account's weight in the mixture of its stretch.
std::vector<double> Weights(const OpenAccounts& accounts) {
  constexpr double kMostGain = 50;  // beyond what a double's exponential holds lies nothing else
  std::vector<double> out;
  double sum = 1;
  for (const OtherAccount& other : accounts.others) {
    out.push_back(std::exp(std::min(other.gain, kMostGain)));
    sum += out.back();
  }
  for (double& weight : out) weight /= sum;
  return out;
}

// What a step in the tangent of another account's state does in that of the kept one, which lies
// by `d` away.
Block InTangentOf(const GraphStep& d) {
  Block out = Block::Identity();
  out.topLeftCorner<3, 3>() = RightJacobianInverseSo3(d.head<3>());
  return out;
}

// The states whose covariances become a mixture's: those of the run, and beside it those that the
// run's velocity moves.
FrameRange Mixed(const OpenAccounts& accounts) {
  constexpr int kMoved = 10;
  const int n = static_cast<int>(accounts.others.front().states.size());
  return {std::max(accounts.run.first - kMoved, accounts.first),
          std::min(accounts.run.last + kMoved, accounts.first + n - 1)};
}

// d before'. Ways that turn apart by a whole turn are half a turn apart in the middle, where the
// difference of attitudes changes its sign and that of the rest does not: those do not go together.
Block Spread(const GraphStep& d, const GraphStep& before, bool of_turns) {
  if (!of_turns) return d * before.transpose();
  GraphStep turn = GraphStep::Zero(), turn_before = turn, rest = d, rest_before = before;
  const double sign = d.head<3>().dot(before.head<3>()) < 0 ? -1 : 1;
  turn.head<3>() = sign * d.head<3>();
  turn_before.head<3>() = before.head<3>();
  rest.head<3>().setZero();
  rest_before.head<3>().setZero();
  return turn * turn_before.transpose() + rest * rest_before.transpose();
}

// The mixture of one stretch into its covariances.
void Mix(const OpenAccounts& accounts, Trajectory* trajectory,
         std::vector<StateCovariance>* covariances) {
  const std::vector<double> weights = Weights(accounts);
  double own = 1;
  for (const double weight : weights) own -= weight;
  const FrameRange range = Mixed(accounts);
  std::vector<GraphStep> before(weights.size());
  for (int k = range.first; k <= range.last; ++k) {
    const auto state = static_cast<size_t>(k), at = static_cast<size_t>(k - accounts.first);
    Block mixed = Block::Zero(), cross = Block::Zero();
    for (size_t i = 0; i < weights.size(); ++i) {
      const OtherAccount& other = accounts.others[i];
      const GraphStep d = Difference(other.states[at], trajectory->states[state]);
      const Block in = InTangentOf(d);
      mixed += weights[i] *
               (in * other.covariances[at] * in.transpose() + Spread(d, d, accounts.of_turns));
      if (k > range.first) {
        cross += weights[i] *
                 (in * other.cross_covariances[at - 1] * InTangentOf(before[i]).transpose() +
                  Spread(d, before[i], accounts.of_turns));
      }
      before[i] = d;
    }
    trajectory->covariances[state] = own * trajectory->covariances[state] + mixed;
    (*covariances)[state] = own * (*covariances)[state] + mixed.topLeftCorner<12, 12>();
    if (k > range.first) {
      Block& of_both = trajectory->cross_covariances[state - 1];
      of_both = own * of_both + cross;
    }
  }
}

}  // namespace

Stretch Around(const GraphInput& whole, const FrameRange& run, int beside) {
  Stretch out;
  const int n = static_cast<int>(whole.frames.size());
  out.states = {std::max(0, run.first - beside), std::min(n - 1, run.last + beside)};
  out.input.frames.assign(whole.frames.begin() + out.states.first,
                          whole.frames.begin() + out.states.last + 1);
  out.input.first_frame = whole.first_frame + out.states.first;
  for (const TrackSegment& segment : whole.segments) {
    const bool inside = segment.first_frame >= out.input.first_frame &&
                        segment.last_frame() <= whole.first_frame + out.states.last;
    if (inside) out.input.segments.push_back(segment);
  }
  return out;
}

bool AreTheSame(const Solution& a, const std::vector<GraphState>& b) {
  for (size_t k = 0; k < b.size(); ++k) {
    const Eigen::Matrix<double, 6, 1> d = Difference(b[k], a.graph.states[k]).head<6>();
    const int i = static_cast<int>(k);
    const PoseCovariance p = a.covariance.At(i, i).topLeftCorner<6, 6>();
    if (!(d.dot(p.llt().solve(d)) < 1)) return false;
  }
  return true;
}

OtherAccount AccountOf(const Solution& solution, double gain) {
  OtherAccount out{solution.graph.states, {}, {}, gain};
  for (int k = 0; k < solution.covariance.size(); ++k) {
    out.covariances.push_back(solution.covariance.At(k, k));
    if (k > 0) out.cross_covariances.push_back(solution.covariance.At(k, k - 1));
  }
  return out;
}

double CostOfCorners(const EstimatorSetup& setup, const NoiseModel& noise,
                     const std::vector<GraphFrame>& frames, const Solution& solution) {
  double sum = 0;
  for (size_t k = 0; k < frames.size(); ++k) {
    sum += CornerCost(setup, noise, frames[k], solution.graph.states[k].pose).value_or(0);
  }
  return sum;
}

bool TakeLikelier(const std::vector<OpenAccounts>& open, GraphInput* input) {
  bool any = false;
  for (const OpenAccounts& accounts : open) {
    const OtherAccount& best = accounts.others.front();
    if (!(best.gain > kLikelier)) continue;
    any = true;
    for (int k = accounts.run.first; k <= accounts.run.last; ++k) {
      GraphFrame& frame = input->frames[static_cast<size_t>(k)];
      const GraphState& state = best.states[static_cast<size_t>(k - accounts.first)];
      frame.state = ToBodyState(state);
      frame.acceleration = ToAcceleration(state);
      frame.motion = state.motion;
    }
  }
  return any;
}

std::vector<bool> CoverOpenAccounts(const std::vector<OpenAccounts>& open, Trajectory* trajectory,
                                    std::vector<StateCovariance>* covariances) {
  std::vector<bool> out(trajectory->states.size(), false);
  for (const OpenAccounts& accounts : open) {
    Mix(accounts, trajectory, covariances);
    const std::vector<double> weights = Weights(accounts);
    for (int k = accounts.run.first; k <= accounts.run.last; ++k) {
      const auto state = static_cast<size_t>(k), at = static_cast<size_t>(k - accounts.first);
      const Pose& here = trajectory->states[state].pose;
      for (size_t i = 0; i < weights.size(); ++i) {
        if (weights[i] < accounts.least_told_weight) continue;
        if (AngleBetween(accounts.others[i].states[at].pose, here) > kOpenRad) out[state] = true;
      }
    }
  }
  return out;
}

std::vector<FrameRange> StatesAround(const std::vector<GraphState>& states,
                                     const std::vector<GraphFrame>& frames) {
  std::vector<FrameRange> out;
  int after = 0;
  const int n = static_cast<int>(states.size());
  for (const GraphFrame& frame : frames) {
    while (after < n && states[static_cast<size_t>(after)].t_ns < frame.t_ns) ++after;
    const bool at = after < n && states[static_cast<size_t>(after)].t_ns == frame.t_ns;
    out.push_back({at ? after : after - 1, after});
  }
  return out;
}

void TellAmbiguous(const std::vector<bool>& ambiguous, const std::vector<FrameRange>& around,
                   std::vector<FrameEstimate>* frames) {
  const int n = static_cast<int>(ambiguous.size());
  const auto is_open = [&](int k) { return k >= 0 && k < n && ambiguous[static_cast<size_t>(k)]; };
  for (size_t i = 0; i < frames->size(); ++i) {
    if (is_open(around[i].first) || is_open(around[i].last)) {
      (*frames)[i].status = FrameStatus::kAmbiguous;
    }
  }
}

}  // namespace tagtwist::internal
