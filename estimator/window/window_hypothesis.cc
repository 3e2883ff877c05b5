#include "estimator/window/window_hypothesis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/graph/linear_system.h"
#include "estimator/graph/marginalisation.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/contradictions.h"

namespace tagtwist {
namespace {

// Newest states within a standard deviation of one another: two minima that are none.
bool TellTheSame(const WindowHypothesis& a, const WindowHypothesis& b) {
  const int newest = static_cast<int>(a.input.frames.size()) - 1;
  const PoseCovariance p = BodyCovariance(a.solution.covariance, newest).topLeftCorner<6, 6>();
  const StateVector d = Difference(b.input.frames.back().state, a.input.frames.back().state);
  return d.head<6>().dot(p.llt().solve(d.head<6>())) < 1;
}

// The oldest state of the last solution's graph leaves for a prior.
void MarginalizeGraph(WindowHypothesis* hypothesis) {
  const Graph& graph = hypothesis->solution.graph;
  const std::vector<bool> use = UsedByMarginalisation(graph);
  for (size_t f = 0; f < use.size(); ++f) {
    LinearFactor linear;
    if (use[f] && LinearizeFactor(graph, graph.factors[f], &linear)) {
      hypothesis->settled_cost += RobustCost(graph.factors[f], linear);
    }
  }
  std::optional<Factor>& prior = hypothesis->input.prior;
  prior = MarginalizeFirstState(graph);
  if (!prior) return;
  Eigen::VectorXd offset(prior->cost->num_residuals());
  std::vector<const double*> at;
  for (const BlockRef& block : prior->blocks) {
    at.push_back(graph.Parameters({block.kind, block.index + 1}));
  }
  prior->cost->Evaluate(at.data(), offset.data(), nullptr);
  hypothesis->settled_cost -= 0.5 * offset.squaredNorm();
}

}  // namespace

void WindowHypothesis::TakePrior() {
  if (is_step) input.prior = system.Prior();
  is_step = false;
}

Status SolveHypothesis(const EstimatorSetup& setup, const NoiseModel& noise,
                       const SolveOptions& options, WindowHypothesis* hypothesis) {
  hypothesis->TakePrior();
  auto solution = SolveAndInvert(setup, noise, hypothesis->input, options);
  if (!solution) return solution.error();
  TakeStates(solution->graph, &hypothesis->input.frames);
  hypothesis->solution = std::move(*solution);
  return Ok();
}

Status StepHypothesis(const EstimatorSetup& setup, const NoiseModel& noise,
                      const SolveOptions& options, WindowHypothesis* hypothesis) {
  if (!hypothesis->is_step) hypothesis->system = WindowSystem();
  auto solution = hypothesis->system.Solve(setup, noise, options, hypothesis->input);
  if (!solution) return solution.error();
  hypothesis->is_step = true;
  TakeStates(solution->graph, &hypothesis->input.frames);
  hypothesis->solution = std::move(*solution);
  return Ok();
}

bool DropContradicted(WindowHypothesis* hypothesis) {
  std::vector<GraphFrame>& frames = hypothesis->input.frames;
  const int newest = static_cast<int>(frames.size()) - 1;
  std::vector<TagRef> wrong;
  if (!hypothesis->is_step) wrong = ContradictedTags(hypothesis->solution.graph);
  for (int k = 0; hypothesis->is_step && k <= newest; ++k) {
    for (const int tag : hypothesis->system.TagsBelow(k, kContradictedWeight)) {
      wrong.push_back({k, tag});
    }
  }
  const auto n_newest = static_cast<size_t>(std::count_if(
      wrong.begin(), wrong.end(), [&](const TagRef& ref) { return ref.state == newest; }));
  if (2 * n_newest > frames.back().tags.size()) return false;
  DropTags(wrong, &frames);
  return !wrong.empty();
}

void MarginalizeOldest(WindowHypothesis* hypothesis) {
  if (hypothesis->is_step) {
    hypothesis->system.MarginalizeFirst();
  } else {
    MarginalizeGraph(hypothesis);
  }
  GraphInput& input = hypothesis->input;
  input.frames.erase(input.frames.begin());
  ++input.first_frame;
}

void Prune(std::vector<WindowHypothesis>* hypotheses) {
  std::stable_sort(
      hypotheses->begin(), hypotheses->end(),
      [](const WindowHypothesis& a, const WindowHypothesis& b) { return a.Cost() < b.Cost(); });
  std::vector<WindowHypothesis> kept;
  for (WindowHypothesis& hypothesis : *hypotheses) {
    const bool other = std::none_of(
        kept.begin(), kept.end(),
        [&](const WindowHypothesis& likelier) { return TellTheSame(likelier, hypothesis); });
    if (kept.empty() || (other && hypothesis.Cost() < kept.front().Cost() + kDecidedCost)) {
      kept.push_back(std::move(hypothesis));
    }
  }
  *hypotheses = std::move(kept);
}

double DoubtOf(const std::vector<WindowHypothesis>& hypotheses) {
  if (hypotheses.size() < 2) return 0;
  return 1 / (1 + std::exp(hypotheses[1].Cost() - hypotheses[0].Cost()));
}

}  // namespace tagtwist
