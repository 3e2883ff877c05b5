#include "estimator/solve/banded_solver.h"

#include <utility>
#include <vector>

#include "estimator/graph/linear_system.h"
#include "frontend/base/format_text.h"
#include "frontend/base/least_squares.h"

namespace tagtwist::internal {
namespace {

void Damp(double damping, BlockBandedMatrix* hessian) {
  if (damping == 0) return;
  for (int k = 0; k < hessian->size(); ++k) hessian->At(k, k).diagonal() *= 1 + damping;
}

// For SolveLeastSquares.
struct BandedProblem {
  using State = std::vector<GraphState>;
  struct Normals {
    double cost = 0;
    LinearSystem system;                 // without its Hessian once it is factorised
    std::optional<double> damping = {};  // in the factors
  };

  Graph* graph;
  std::string fault;                                 // the last one
  std::optional<BlockBandedCholesky> cholesky = {};  // of the last normals

  std::optional<Normals> Linearise(const State& states) {
    graph->states = states;
    Normals out;
    out.system = Linearize(*graph, {}, TakeMemory(&cholesky));
    out.cost = out.system.cost;
    if (out.system.is_whole) return out;
    fault = "a factor cannot be evaluated, a corner behind the camera as a rule";
    return std::nullopt;
  }

  // Anew where the Hessian is used up; the matrix is large, so that there should be no copy.
  bool Factorise(const State& states, double damping, Normals* normals) {
    if (cholesky && normals->damping == damping) return cholesky->ok();
    if (normals->damping) *normals = *Linearise(states);
    Damp(damping, &normals->system.hessian);
    normals->damping = damping;
    cholesky.emplace(std::move(normals->system.hessian));
    if (!cholesky->ok()) fault = NotPositiveDefinite(*cholesky, states);
    return cholesky->ok();
  }

  std::optional<LeastSquaresStep<Eigen::VectorXd>> Solve(const State& states, double damping,
                                                         Normals* normals) {
    if (!Factorise(states, damping, normals)) return std::nullopt;
    LeastSquaresStep<Eigen::VectorXd> step{cholesky->Solve(-normals->system.gradient), 0, false};
    step.decrease = -0.5 * normals->system.gradient.dot(step.dx);
    return step;
  }

  static State Step(const State& states, const Eigen::VectorXd& dx) { return Retract(states, dx); }
};

LeastSquaresOptions SearchOptions(const SolveOptions& options) {
  LeastSquaresOptions out;
  out.max_steps = options.max_iterations;
  out.least_damping = 1e-10;
  out.most_damping = 1e4;
  out.damping_factor = 100;
  out.relative_tolerance = options.function_tolerance;
  out.tolerance_of_next = kNoDecrease;
  out.rounding = 1e-11;
  out.time_up = options.time_up;
  return out;
}

std::string Message(LeastSquaresEnd end, const std::string& fault) {
  if (end == LeastSquaresEnd::kStuck) {
    return "no step lowers the cost, however damped" + (fault.empty() ? "" : ": " + fault);
  }
  return fault.empty() ? "the cost has no value where the states start" : fault;
}

}  // namespace

std::string NotPositiveDefinite(const BlockBandedCholesky& cholesky,
                                const std::vector<GraphState>& states) {
  const int k = cholesky.failed_at();
  return Format(
      "the normal equations are not positive definite at state %d of %d, of stamp %lld ns: nothing "
      "ties all of it, or it is tied beyond what doubles can hold",
      k + 1, static_cast<int>(states.size()),
      static_cast<long long>(states[static_cast<size_t>(k)].t_ns));
}

bool IsBanded(const Graph& graph) { return graph.points.empty(); }

BandedSolution SolveBanded(const SolveOptions& options, Graph* graph) {
  BandedSolution out;
  BandedProblem problem{graph, {}};
  auto found = SolveLeastSquares(problem, graph->states, SearchOptions(options));
  graph->states = std::move(found.x);
  out.summary.iterations = found.steps;
  out.summary.final_cost = found.cost;
  const bool has_end =
      found.end != LeastSquaresEnd::kStuck && found.end != LeastSquaresEnd::kNotEvaluable;
  if (has_end && problem.Factorise(graph->states, 0, &*found.normals)) {
    out.summary.usable = true;
    out.normal_equations = std::move(problem.cholesky);
  } else {
    out.summary.message = Message(found.end, problem.fault);
  }
  return out;
}

}  // namespace tagtwist::internal
