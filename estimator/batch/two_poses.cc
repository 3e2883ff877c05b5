#include "estimator/batch/two_poses.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "estimator/solve/noise_rounds.h"
#include "estimator/start/mirror.h"

namespace tagtwist::internal {
namespace {

// States on either side of a run that are solved with it: what lies beyond says nothing of it.
constexpr int kBeside = 30;

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
  const Stretch stretch = Around(whole, run.frames, kBeside);
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

}  // namespace tagtwist::internal
