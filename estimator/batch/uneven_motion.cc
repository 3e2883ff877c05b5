#include "estimator/batch/uneven_motion.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/linear_system.h"
#include "estimator/linear/block_banded.h"
#include "estimator/motion/motion_profile.h"
#include "estimator/solve/banded_solver.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/noise_rounds.h"

namespace tagtwist::internal {
namespace {

// In the logarithm of a likelihood: beyond doubt.
constexpr double kClearlyUneven = 10;

// Of the poses under one density, the likeliest near the learned one.
PartLikelihoods BestOfOneDensity(const MotionHistory& history, const NoiseModel& noise) {
  PartLikelihoods best{-std::numeric_limits<double>::max(), -std::numeric_limits<double>::max()};
  for (const double factor : {0.1, 0.3, 1.0, 3.0, 10.0}) {
    const PartLikelihoods here = history.Likelihoods(
        UnderOneDensity(WithDensity(noise.linear, factor * noise.linear.psd),
                        WithDensity(noise.angular, factor * noise.angular.psd)));
    best = {std::max(best.linear, here.linear), std::max(best.angular, here.angular)};
  }
  return best;
}

// What a second solve changes, to be had back should it be no better.
struct Before {
  std::vector<GraphFrame> frames;  // without their tags
  std::vector<TrackSegment> segments;
};

Before Keep(const GraphInput& input) {
  Before out;
  out.frames.reserve(input.frames.size());
  for (const GraphFrame& frame : input.frames) {
    out.frames.push_back({frame.t_ns, frame.state, frame.acceleration, frame.motion, {}, {}});
  }
  out.segments = input.segments;
  return out;
}

// The covariance is soon had again of the graph, and a graph without points of its input: of long
// recordings two of them would be a lot to hold.
void GiveUpMemory(Solution* solution) {
  solution->covariance = BlockBandedMatrix();
  if (solution->graph.points.empty() && solution->graph.n_left_out == 0) {
    solution->graph.factors = std::vector<Factor>();
  }
}

Result<Solution> TakeBack(const EstimatorSetup& setup, const NoiseModel& noise,
                          const Before& before, Solution solution, GraphInput* input) {
  for (size_t k = 0; k < input->frames.size(); ++k) {
    const GraphFrame& from = before.frames[k];
    GraphFrame& to = input->frames[k];
    to.state = from.state;
    to.acceleration = from.acceleration;
    to.motion = from.motion;
  }
  input->segments = before.segments;
  if (solution.graph.factors.empty()) solution.graph = BuildGraph(setup, noise, *input);
  BlockBandedCholesky cholesky(Linearize(solution.graph).hessian);
  if (!cholesky.ok()) return Error{NotPositiveDefinite(cholesky, solution.graph.states)};
  solution.covariance = std::move(cholesky).SelectedInverse();
  return solution;
}

// Whether the motion of either part varies; if so the input gets by how much from frame to frame.
bool FindMotion(const EstimatorSetup& setup, const NoiseModel& noise, GraphInput* input) {
  const MotionHistory history = HistoryOf(setup, noise, input->frames, false);
  if (!history.banks().is_measured()) return false;
  const PartLikelihoods one = BestOfOneDensity(history, noise),
                        many = history.Likelihoods(MotionBanks(noise.linear, noise.angular));
  const MotionParts varying{many.linear > one.linear + kClearlyUneven,
                            many.angular > one.angular + kClearlyUneven};
  if (!varying.linear && !varying.angular) return false;
  TakeMotion(history, noise, varying, &input->frames);
  return true;
}

}  // namespace

Result<Solution> LetMotionVary(const EstimatorSetup& setup, const SolveOptions& options,
                               Solution solution, GraphInput* input, NoiseModel* noise) {
  if (!MotionIsLearned(setup.options)) return solution;
  const Before before = Keep(*input);
  if (!FindMotion(setup, *noise, input)) return solution;
  GiveUpMemory(&solution);
  NoiseModel learned = *noise;
  auto out = SolveAndLearn(setup, options, input, &learned);
  if (!out || !(out->log_likelihood > solution.log_likelihood + kClearlyUneven)) {
    return TakeBack(setup, *noise, before, std::move(solution), input);
  }
  *noise = learned;
  return out;
}

}  // namespace tagtwist::internal
