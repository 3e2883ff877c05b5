#include "estimator/solve/noise_rounds.h"

#include <algorithm>
#include <utility>

#include "estimator/graph/noise_model.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/noise_extrapolation.h"
#include "estimator/solve/noise_statistics.h"
#include "estimator/solve/quadratic_chain.h"

namespace tagtwist::internal {
namespace {

void DropSegments(const std::vector<bool>& drop, GraphInput* input) {
  std::vector<TrackSegment> kept;
  for (size_t s = 0; s < drop.size(); ++s) {
    if (!drop[s]) kept.push_back(std::move(input->segments[s]));
  }
  input->segments = std::move(kept);
}

// A round: solves under this noise, as finely as a last round must be or coarsely; leaves its
// statistics, and whether it took anything out of the problem.
struct NoiseRound {
  Result<Solution> solution;
  NoiseStatistics statistics;
  bool has_dropped = false;
};

// What is known of corners that say nothing of their noise themselves, beside few that show it: by
// chance these lie next to nothing from their predictions. So many observations of that deviation.
VarianceStatistic KnownOfCorners(const GraphInput& input) {
  constexpr double kUsualSigmaPx = 0.25, kWeight = 3;
  constexpr size_t kEnough = 10;  // degrees of freedom
  size_t rows = 0, taken = 0;
  for (const GraphFrame& frame : input.frames) {
    for (const TagDetection& tag : frame.tags) {
      if (tag.covariance) return {};
      rows += 8;
    }
    if (!frame.tags.empty()) taken += 6;
    if (rows >= taken + kEnough) return {};
  }
  return {kWeight * kUsualSigmaPx * kUsualSigmaPx, kWeight};
}

// SolveAndLearn, by what makes a round.
template <typename MakeRound>
Result<Solution> Learn(const EstimatorOptions& options, bool is_open, const LearnOptions& learn,
                       const VarianceStatistic& known_of_corners, const TimeUp& time_up,
                       NoiseModel* noise, const MakeRound& make_round) {
  constexpr int kMaxRounds = 20;
  constexpr double kNear = 0.05;  // with less to go a round's solution may be the last
  NoiseExtrapolation extrapolation;
  double change = is_open ? 1 : 0;
  for (int i = 0; i < kMaxRounds && change >= learn.settled; ++i) {
    const bool may_be_last = change < kNear;
    NoiseRound round = make_round(*noise, may_be_last);
    if (!round.solution) return round.solution.error();
    round.statistics.corner += known_of_corners;
    const NoiseModel updated = UpdateNoise(*noise, round.statistics, options, learn.least_dof);
    change = NoiseChange(updated, *noise);
    if (may_be_last && change < learn.settled && !round.has_dropped) {
      noise->source = updated.source;
      return std::move(round.solution);
    }
    *noise = extrapolation.Next(*noise, updated);
    if (IsUp(time_up)) return std::move(round.solution);
  }
  return make_round(*noise, true).solution;
}

SolveOptions Coarse(const SolveOptions& options) {
  SolveOptions out = options;
  out.function_tolerance = std::max(options.function_tolerance, 1e-4);
  return out;
}

Result<Solution> LearnInGraph(const EstimatorSetup& setup, const SolveOptions& options,
                              GraphInput* input, NoiseModel* noise, const LearnOptions& learn) {
  const StateRange all{0, static_cast<int>(input->frames.size())};
  const auto round = [&](const NoiseModel& with, bool fine) -> NoiseRound {
    NoiseRound out{
        SolveAndInvert(setup, with, *input, fine ? options : Coarse(options)), {}, false};
    if (!out.solution) return out;
    const Graph& graph = out.solution->graph;
    TakeStates(graph, &input->frames);
    out.statistics = ComputeNoiseStatistics(graph, out.solution->covariance, with, all);
    const std::vector<bool> wrong = ContradictedSegments(graph, input->segments.size());
    out.has_dropped = std::find(wrong.begin(), wrong.end(), true) != wrong.end();
    DropSegments(wrong, input);
    return out;
  };
  // Segments may have to go even where all noise is given.
  const bool is_open = AnyNoiseIsOpen(setup.options) || !input->segments.empty();
  return Learn(setup.options, is_open, learn, KnownOfCorners(*input), options.time_up, noise,
               round);
}

// SolveAndLearn by a chain of that graph, where there are no points; an error where it takes damped
// steps.
Result<Solution> LearnInChain(const EstimatorSetup& setup, const SolveOptions& options, Graph graph,
                              GraphInput* input, NoiseModel* noise, const LearnOptions& learn) {
  constexpr ChainRules kFine{0, false}, kCoarse{1e-2, false};
  QuadraticChain chain(std::move(graph), setup.for_ranges);
  const auto round = [&](const NoiseModel& with, bool fine) -> NoiseRound {
    chain.ChangeFactors([&](const Graph& of_chain, Factor* factor) {
      SetNoise(setup, with, *input, of_chain, factor);
    });
    auto solved = fine ? chain.Solve(options, kFine) : chain.Solve(Coarse(options), kCoarse);
    if (!solved) return {solved.error(), {}, false};
    chain.LinearizeForms();
    const NoiseStatistics statistics =
        ComputeNoiseStatistics(chain, solved->covariance, with, setup.for_ranges);
    return {Solution{{}, std::move(solved->covariance), solved->log_likelihood, solved->cost},
            statistics, false};
  };
  auto solution = Learn(setup.options, AnyNoiseIsOpen(setup.options), learn, KnownOfCorners(*input),
                        options.time_up, noise, round);
  if (!solution) return solution;
  solution->graph = std::move(chain).TakeGraph();
  TakeStates(solution->graph, &input->frames);
  return solution;
}

}  // namespace

Result<Solution> SolveAndLearn(const EstimatorSetup& setup, const SolveOptions& options,
                               GraphInput* input, NoiseModel* noise, const LearnOptions& learn) {
  if (setup.options.solver == Solver::kAuto && !HasTracks(setup, *input)) {
    Graph graph = BuildGraph(setup, *noise, *input);
    NoiseModel learned = *noise;
    if (graph.n_left_out == 0) {
      auto solution = LearnInChain(setup, options, std::move(graph), input, &learned, learn);
      if (solution) {
        *noise = learned;
        return solution;
      }
    }
  }
  return LearnInGraph(setup, options, input, noise, learn);
}

}  // namespace tagtwist::internal
