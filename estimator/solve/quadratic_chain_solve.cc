#include <atomic>
#include <string>
#include <utility>

#include "estimator/solve/banded_solver.h"
#include "estimator/solve/quadratic_chain.h"
#include "frontend/base/least_squares.h"

namespace tagtwist::internal {
namespace {

constexpr int kSize = BlockBandedMatrix::kSize;
// What of the turn between two states changes is squared in what a linearised motion neglects.
constexpr double kBetweenRad = 1e-4, kOfBothRad = 2e-3;

// Of a symmetric matrix, into the first n states' blocks.
void AddBlocks(const Eigen::MatrixXd& hessian, int n, BlockBandedMatrix* out) {
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) {
      out->At(i, j) += hessian.block<kSize, kSize>(kSize * i, kSize * j);
    }
  }
}

}  // namespace

// And what is partial: it may be whole by now. False where a factor cannot be evaluated.
bool QuadraticChain::LinearizeWhatMoved(double neglected) {
  std::atomic<bool> all{true};
  for_ranges_(forms_.size(), [&](size_t first, size_t last) {
    LinearFactor scratch;
    for (size_t k = first; k < last; ++k) {
      const bool holds = forms_[k].Holds(graph_, graph_.states[k].pose, neglected);
      if (holds && !forms_[k].is_partial) continue;
      if (!forms_[k].Linearize(graph_, &scratch)) all = false;
    }
  });
  return all;
}

bool QuadraticChain::Holds(const std::vector<GraphState>& moved, double neglected) const {
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < moved.size(); ++k) {
    if (!forms_[k].Holds(graph_, moved[k].pose, neglected)) return false;
    const Eigen::Vector3d turn = Difference(moved[k].pose, graph_.states[k].pose).head<3>();
    if (k > 0 && ((turn - before).norm() > kBetweenRad || turn.norm() > kOfBothRad)) return false;
    before = turn;
  }
  return true;
}

// The cost of a factor, which is added; nullopt where it cannot be evaluated.
std::optional<double> QuadraticChain::Add(size_t f, LinearFactor* scratch,
                                          LinearSystem* out) const {
  const Factor& factor = graph_.factors[f];
  if (!LinearizeFactor(graph_, factor, scratch)) return std::nullopt;
  AddFactor(factor, *scratch, out);
  return RobustCost(factor, *scratch);
}

// A range's last step reaches into the next range's first state: it is added afterwards. No state
// gets more than two terms until then, so that their order does not matter.
void QuadraticChain::AddSteps(LinearSystem* out) const {
  std::vector<std::optional<double>> costs(steps_.size(), 0.0);
  std::vector<char> is_last(steps_.size());
  const auto add = [&](size_t k, LinearFactor* scratch) {
    if (steps_[k] >= 0) costs[k] = Add(static_cast<size_t>(steps_[k]), scratch, out);
  };
  for_ranges_(steps_.size(), [&](size_t first, size_t last) {
    LinearFactor scratch;
    for (size_t k = first; k + 1 < last; ++k) add(k, &scratch);
    is_last[last - 1] = true;
  });
  LinearFactor scratch;
  for (size_t k = 0; k < steps_.size(); ++k) {
    if (is_last[k]) add(k, &scratch);
    out->is_whole = out->is_whole && costs[k];
    out->cost += costs[k].value_or(0);
  }
}

// Of the first states, and the prior.
void QuadraticChain::AddForms(size_t n_states, LinearSystem* out) const {
  for (size_t k = 0; k < n_states; ++k) {
    const PoseForm& tags = forms_[k];
    if (tags.factors.empty()) continue;
    const int i = static_cast<int>(k);
    const double scale = tags.Scale(graph_);
    double cost = 0;
    const PoseStep gradient = tags.form.GradientAt(graph_.states[k].pose, &cost);
    out->hessian.At(i, i).topLeftCorner<6, 6>() += scale * tags.form.hessian;
    out->gradient.segment<6>(kSize * i) += scale * gradient;
    out->cost += scale * cost;
  }
  if (!prior_) return;
  const int n = static_cast<int>(prior_->reference.size());
  if (tangent_ == PriorTangent::kOwn) {
    out->gradient.head(kSize * n) += prior_->GradientAt(graph_.states, &out->cost);
    AddBlocks(prior_->hessian, n, &out->hessian);
    return;
  }
  Eigen::VectorXd moved(kSize * n);
  for (int k = 0; k < n; ++k) {
    const auto i = static_cast<size_t>(k);
    moved.segment<kSize>(kSize * k) =
        DifferenceInWorld(graph_.states[i], prior_->reference[i], tangent_);
  }
  const Eigen::MatrixXd by_step = PriorByStep();
  out->gradient.head(kSize * n) += by_step.transpose() * prior_->GradientAtMoved(moved, &out->cost);
  AddBlocks(by_step.transpose() * prior_->hessian * by_step, n, &out->hessian);
}

LinearSystem QuadraticChain::Assemble(BlockBandedMatrix memory) const {
  LinearSystem out =
      ZeroSystem(static_cast<int>(graph_.states.size()), bandwidth_, std::move(memory));
  AddSteps(&out);
  AddForms(forms_.size(), &out);
  LinearFactor scratch;
  for (const size_t f : others_) {
    const auto cost = Add(f, &scratch, &out);
    out.is_whole = out.is_whole && cost;
    out.cost += cost.value_or(0);
  }
  return out;
}

double QuadraticChain::LogDetInformation() const {
  double sum = 0;
  for (const Factor& factor : graph_.factors) sum += factor.LogDetInformation();
  return 0.5 * sum;
}

// For SolveLeastSquares. No step is damped: where one fails another solver does better.
struct QuadraticChain::Problem {
  using State = std::vector<GraphState>;
  struct Normals {
    double cost = 0;
    LinearSystem system;  // without its Hessian once it is factorised
  };

  QuadraticChain* chain;
  ChainRules rules;
  std::string fault;
  std::optional<BlockBandedCholesky> cholesky = {};  // of the last normals

  std::optional<Normals> Linearise(const State& states) {
    chain->graph_.states = states;
    const bool all = chain->LinearizeWhatMoved(rules.neglected);
    Normals out;
    out.system = chain->Assemble(TakeMemory(&cholesky));
    out.cost = out.system.cost;
    // The window goes without what it cannot evaluate.
    if (rules.ends_when_forms_hold || (all && out.system.is_whole)) return out;
    fault = "a factor cannot be evaluated where its states have moved to";
    return std::nullopt;
  }

  // The normal equations' factors; false where they have none.
  bool Factorise(Normals* normals) {
    if (!cholesky) cholesky.emplace(std::move(normals->system.hessian));
    if (cholesky->ok()) return true;
    fault = NotPositiveDefinite(*cholesky, chain->graph_.states);
    return false;
  }

  std::optional<LeastSquaresStep<Eigen::VectorXd>> Solve(const State& states, double /*damping*/,
                                                         Normals* normals) {
    if (!Factorise(normals)) return std::nullopt;
    LeastSquaresStep<Eigen::VectorXd> step{cholesky->Solve(-normals->system.gradient), 0, false};
    step.decrease = -0.5 * normals->system.gradient.dot(step.dx);
    step.is_last =
        rules.ends_when_forms_hold && chain->Holds(Step(states, step.dx), rules.neglected);
    return step;
  }

  static State Step(const State& states, const Eigen::VectorXd& dx) { return Retract(states, dx); }
};

Result<ChainSolution> QuadraticChain::Solve(const SolveOptions& options, const ChainRules& rules) {
  LeastSquaresOptions search;
  search.max_steps = options.max_iterations;
  search.most_damping = 0;
  search.time_up = options.time_up;
  search.takes_any_step = rules.ends_when_forms_hold;
  search.neglected = rules.neglected;
  search.rounding = 1e-9;
  if (!rules.ends_when_forms_hold) {
    search.relative_tolerance = options.function_tolerance;
    search.tolerance_of_next = kNoDecrease;
  }
  Problem problem{this, rules, "a full step raises the cost"};
  auto found = SolveLeastSquares(problem, graph_.states, search);
  graph_.states = std::move(found.x);
  const bool in_time = found.converged() || found.end == LeastSquaresEnd::kTimeUp;
  const bool may_stop =
      in_time || (rules.ends_when_forms_hold && found.end == LeastSquaresEnd::kStepLimit);
  if (found.end == LeastSquaresEnd::kStepLimit && !may_stop) {
    return Error{"full steps do not come to an end"};
  }
  if (!may_stop || !problem.Factorise(&*found.normals)) return Error{problem.fault};
  BlockBandedCholesky& cholesky = *problem.cholesky;
  ChainSolution out;
  out.cost = found.cost;
  out.log_likelihood = LogDetInformation() - out.cost - 0.5 * cholesky.LogDeterminant();
  out.covariance = std::move(cholesky).SelectedInverse();
  return out;
}

}  // namespace tagtwist::internal
