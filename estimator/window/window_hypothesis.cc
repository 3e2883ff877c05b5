#include "estimator/window/window_hypothesis.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/graph/linear_system.h"
#include "estimator/graph/marginalisation.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/noise_rounds.h"
#include "estimator/start/mirror.h"

namespace tagtwist::internal {
namespace {

constexpr double kSettledNoise = LearnOptions().settled;

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

// The chain as the input has become since its last solve.
void Follow(const EstimatorSetup& setup, const NoiseModel& noise, WindowHypothesis* hypothesis) {
  QuadraticChain& chain = hypothesis->chain;
  const std::vector<GraphFrame>& frames = hypothesis->input.frames;
  for (size_t k = 0; k < chain.graph().states.size(); ++k) {
    chain.SetMotion(static_cast<int>(k), frames[k].motion);
  }
  for (const int k : hypothesis->revised) {
    std::vector<Factor> factors =
        FactorsOfFrame(setup, noise, frames[static_cast<size_t>(k)], chain.graph(), k);
    const auto kept = std::remove_if(factors.begin(), factors.end(),
                                     [](const Factor& f) { return !f.IsOnOnePose(); });
    factors.erase(kept, factors.end());
    chain.ReplaceFactorsOfPose(k, std::move(factors));
  }
  // Motion is linearised anyway. To give all tags another noise costs more, and is left to changes
  // that the learning of noise takes for some, too.
  double& sigma_px = hypothesis->corner_sigma_px;
  const bool renews_tags = std::abs(std::log(noise.corner_sigma_px / sigma_px)) > kSettledNoise;
  if (renews_tags) sigma_px = noise.corner_sigma_px;
  chain.ChangeFactors([&](const Graph& graph, Factor* factor) {
    const bool is_tag = factor->kind == FactorKind::kTag;
    if (renews_tags || !is_tag) SetNoise(setup, noise, hypothesis->input, graph, factor);
  });
  for (size_t k = chain.graph().states.size(); k < frames.size(); ++k) {
    chain.AddState(
        ToGraphState(frames[k].t_ns, frames[k].state, frames[k].acceleration, frames[k].motion));
    chain.AddFactors(FactorsOfFrame(setup, noise, frames[k], chain.graph(), static_cast<int>(k)));
  }
}

}  // namespace

int InSolution(const WindowHypothesis& hypothesis, int frame) {
  const std::vector<GraphState>& states = hypothesis.solution.graph.states;
  const int64_t t_ns = hypothesis.input.frames[static_cast<size_t>(frame)].t_ns;
  const auto found = std::find_if(states.begin(), states.end(),
                                  [t_ns](const GraphState& state) { return state.t_ns == t_ns; });
  return static_cast<int>(found - states.begin());
}

void WindowHypothesis::TakePrior() {
  if (is_step && chain.Prior()) input.prior = chain.Prior();
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
  // A turn of a standard deviation and a thousandth shows nowhere.
  constexpr ChainRules kRules{1e-3, true};
  QuadraticChain& chain = hypothesis->chain;
  if (hypothesis->is_step) {
    Follow(setup, noise, hypothesis);
  } else {
    chain = QuadraticChain(BuildWholeGraph(setup, noise, hypothesis->input));
    hypothesis->corner_sigma_px = noise.corner_sigma_px;
  }
  hypothesis->revised.clear();
  auto solved = chain.Solve(options, kRules);
  if (!solved) return solved.error();
  hypothesis->is_step = true;
  TakeStates(chain.graph(), &hypothesis->input.frames);
  Solution& solution = hypothesis->solution;
  solution = {{}, std::move(solved->covariance), solved->log_likelihood, solved->cost};
  solution.graph.states = chain.graph().states;
  return Ok();
}

namespace {

std::vector<TagRef> Contradicted(const WindowHypothesis& hypothesis) {
  return hypothesis.is_step ? ContradictedTags(hypothesis.chain)
                            : ContradictedTags(hypothesis.solution.graph);
}

// Frames most of whose tags are among those.
std::vector<bool> MostOfFrame(const std::vector<TagRef>& wrong,
                              const std::vector<GraphFrame>& frames) {
  std::vector<size_t> count(frames.size(), 0);
  for (const TagRef& ref : wrong) ++count[static_cast<size_t>(ref.state)];
  std::vector<bool> out(frames.size());
  for (size_t k = 0; k < frames.size(); ++k) out[k] = 2 * count[k] > frames[k].tags.size();
  return out;
}

}  // namespace

bool Outranks(const EstimatorSetup& setup, const NoiseModel& noise, const MotionHistory& motion,
              const GraphFrame& frame) {
  const Pose& pose = frame.state.world_from_body;
  if (motion.Follows(frame.tags)) {
    const auto shown = MotionShownByLoneTag(setup, noise.corner_sigma_px, frame.tags, pose);
    return shown && shown->is_only;
  }
  const auto alone = PoseOfTags(setup, noise.corner_sigma_px, frame.tags, pose);
  return alone && alone->is_consensus;
}

bool DropContradicted(const EstimatorSetup& setup, const NoiseModel& noise,
                      WindowHypothesis* hypothesis) {
  std::vector<GraphFrame>& frames = hypothesis->input.frames;
  std::vector<TagRef> wrong = Contradicted(*hypothesis);
  const std::vector<bool> most = MostOfFrame(wrong, frames);
  if (most.back()) return false;
  std::vector<bool> outranks(frames.size(), false);
  for (size_t k = 0; k < frames.size(); ++k) {
    outranks[k] = most[k] && Outranks(setup, noise, hypothesis->motion, frames[k]);
  }
  const auto stays = [&](const TagRef& ref) { return outranks[static_cast<size_t>(ref.state)]; };
  wrong.erase(std::remove_if(wrong.begin(), wrong.end(), stays), wrong.end());
  DropTags(wrong, &frames);
  for (const TagRef& tag : wrong) hypothesis->revised.push_back(tag.state);
  std::sort(hypothesis->revised.begin(), hypothesis->revised.end());
  hypothesis->revised.erase(std::unique(hypothesis->revised.begin(), hypothesis->revised.end()),
                            hypothesis->revised.end());
  return !wrong.empty();
}

bool NewestContradicts(const EstimatorSetup& setup, const NoiseModel& noise,
                       const WindowHypothesis& hypothesis) {
  const std::vector<GraphFrame>& frames = hypothesis.input.frames;
  return MostOfFrame(Contradicted(hypothesis), frames).back() &&
         Outranks(setup, noise, hypothesis.motion, frames.back());
}

void MarginalizeOldest(WindowHypothesis* hypothesis) {
  if (hypothesis->is_step) {
    hypothesis->chain.MarginalizeFirst();
  } else {
    MarginalizeGraph(hypothesis);
  }
  GraphInput& input = hypothesis->input;
  input.frames.erase(input.frames.begin());
  hypothesis->motion.DropFirst();
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

}  // namespace tagtwist::internal
