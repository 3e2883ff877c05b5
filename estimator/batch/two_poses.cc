#include "estimator/batch/two_poses.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "estimator/solve/noise_rounds.h"
#include "estimator/start/mirror.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

// Attitudes that lie further apart are open: 5 degrees.
constexpr double kOpenRad = 0.0873;
// Gain in the logarithm of a likelihood that is worth solving everything anew.
constexpr double kLikelier = 0.5;
// States on either side of a run that are solved with it: what lies beyond says nothing of it.
constexpr int kBeside = 30;

// A run with the frames beside it, as a problem of its own.
struct Stretch {
  FrameRange states;  // in the whole
  GraphInput input;
};

Stretch Around(const GraphInput& whole, const FrameRange& run) {
  Stretch out;
  const int n = static_cast<int>(whole.frames.size());
  out.states = {std::max(0, run.first - kBeside), std::min(n - 1, run.last + kBeside)};
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

// States within a standard deviation of one another: two minima that are none.
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

// Logarithm of the other's likelihood over the kept one's. No body's motion is white noise: whether
// one seen face-on swung on or back, the density that was learned elsewhere says with far too much
// confidence. What is not of the corners counts a tenth: enough where a body would have to jump.
double GainOf(const Solution& other, double corners_of_other, const Solution& kept,
              double corners_of_kept) {
  constexpr double kTrustInMotion = 0.1;
  const double of_all = other.log_likelihood - kept.log_likelihood;
  const double of_corners = corners_of_kept - corners_of_other;
  return of_corners + kTrustInMotion * (of_all - of_corners);
}

// The accounts of a run beside the one that the input has, the likeliest first.
std::optional<OpenAccounts> OthersOf(const EstimatorSetup& setup, const SolveOptions& options,
                                     const NoiseModel& noise, const GraphInput& whole,
                                     const OpenRun& run) {
  const Stretch stretch = Around(whole, run.frames);
  OpenAccounts out{stretch.states.first, run.frames, {}};
  const auto kept = SolveAndInvert(setup, noise, stretch.input, options);
  if (!kept) return std::nullopt;
  const std::vector<GraphFrame>& frames = stretch.input.frames;
  const double corners = CostOfCorners(setup, noise, frames, *kept);
  for (const FrameRange& range : run.stretches) {
    GraphInput input = stretch.input;
    MirrorFrames(setup, {range.first - out.first, range.last - out.first}, &input.frames);
    const auto other = SolveAndInvert(setup, noise, input, options);
    // An account that leaves something out is no account of the same.
    if (!other || other->graph.n_left_out != kept->graph.n_left_out) continue;
    const double gain = GainOf(*other, CostOfCorners(setup, noise, frames, *other), *kept, corners);
    const bool is_known =
        AreTheSame(*other, kept->graph.states) ||
        std::any_of(out.others.begin(), out.others.end(), [&](const OtherAccount& account) {
          return AreTheSame(*other, account.states);
        });
    if (gain > -kDecidedCost && !is_known) out.others.push_back(AccountOf(*other, gain));
  }
  if (out.others.empty()) return std::nullopt;
  std::stable_sort(out.others.begin(), out.others.end(),
                   [](const OtherAccount& a, const OtherAccount& b) { return a.gain > b.gain; });
  return out;
}

std::vector<OpenAccounts> FindOthers(const EstimatorSetup& setup, const SolveOptions& options,
                                     const NoiseModel& noise, const GraphInput& input) {
  std::vector<OpenAccounts> out;
  for (const OpenRun& run : FindOpenRuns(setup, noise, input.frames)) {
    auto others = OthersOf(setup, options, noise, input, run);
    if (others) out.push_back(std::move(*others));
  }
  return out;
}

// Puts the frames where likelier accounts have them; whether there were any.
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
    }
  }
  return any;
}

// An account's weight in the mixture of its stretch.
std::vector<double> Weights(const OpenAccounts& accounts) {
  double sum = 1;
  for (const OtherAccount& other : accounts.others) sum += std::exp(other.gain);
  std::vector<double> out;
  for (const OtherAccount& other : accounts.others) out.push_back(std::exp(other.gain) / sum);
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
      mixed += weights[i] * (in * other.covariances[at] * in.transpose() + d * d.transpose());
      if (k > range.first) {
        cross += weights[i] *
                 (in * other.cross_covariances[at - 1] * InTangentOf(before[i]).transpose() +
                  d * before[i].transpose());
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

Result<Solution> DecideTwoPoses(const EstimatorSetup& setup, const SolveOptions& options,
                                Solution solution, GraphInput* input, NoiseModel* noise,
                                std::vector<OpenAccounts>* open) {
  constexpr int kMostRounds = 3;
  for (int round = 0;; ++round) {
    *open = FindOthers(setup, options, *noise, *input);
    if (open->empty() || round == kMostRounds) return solution;
    GraphInput likelier = *input;
    if (!TakeLikelier(*open, &likelier)) return solution;
    NoiseModel learned = *noise;
    auto anew = SolveAndLearn(setup, options, &likelier, &learned);
    // What is kept then has both accounts in its covariance.
    if (!anew || !(anew->log_likelihood > solution.log_likelihood)) return solution;
    solution = std::move(*anew);
    *input = std::move(likelier);
    *noise = learned;
  }
}

std::vector<bool> CoverTwoPoses(const std::vector<OpenAccounts>& open, Trajectory* trajectory,
                                std::vector<StateCovariance>* covariances) {
  std::vector<bool> out(trajectory->states.size(), false);
  for (const OpenAccounts& accounts : open) {
    Mix(accounts, trajectory, covariances);
    for (int k = accounts.run.first; k <= accounts.run.last; ++k) {
      const auto state = static_cast<size_t>(k), at = static_cast<size_t>(k - accounts.first);
      out[state] = std::any_of(
          accounts.others.begin(), accounts.others.end(), [&](const OtherAccount& other) {
            const Pose &there = other.states[at].pose, &here = trajectory->states[state].pose;
            return AngleBetween(there, here) > kOpenRad;
          });
    }
  }
  return out;
}

void TellAmbiguous(const std::vector<bool>& ambiguous, const std::vector<int>& state_of_frame,
                   std::vector<FrameEstimate>* frames) {
  size_t next = 0;  // state
  for (size_t i = 0; i < frames->size(); ++i) {
    const bool sees = state_of_frame[i] >= 0;
    if (sees) next = static_cast<size_t>(state_of_frame[i]) + 1;
    const bool here = next > 0 && ambiguous[next - 1];
    const bool after = !sees && next < ambiguous.size() && ambiguous[next];
    if (here || after) (*frames)[i].status = FrameStatus::kAmbiguous;
  }
}

}  // namespace tagtwist::internal
