#include "estimator/solve/banded_solver.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "estimator/graph/linear_system.h"

namespace tagtwist {
namespace {

constexpr int kSize = BlockBandedMatrix::kSize;
// Decrease, as a share of the cost, that rounding may hide.
constexpr double kRounding = 1e-11;
// Damping, as a multiple of the diagonal: none while steps succeed, from kLeast on when one fails.
constexpr double kLeastDamping = 1e-10, kMostDamping = 1e4;

std::vector<GraphState> Retract(const std::vector<GraphState>& states,
                                const Eigen::VectorXd& step) {
  std::vector<GraphState> out;
  out.reserve(states.size());
  for (size_t k = 0; k < states.size(); ++k) {
    out.push_back(
        tagtwist::Retract(states[k], step.segment<kSize>(kSize * static_cast<Eigen::Index>(k))));
  }
  return out;
}

void Damp(double damping, BlockBandedMatrix* hessian) {
  if (damping == 0) return;
  for (int k = 0; k < hessian->size(); ++k) hessian->At(k, k).diagonal() *= 1 + damping;
}

bool IsUsable(const LinearSystem& system) {
  return system.is_whole && system.cost <= std::numeric_limits<double>::max();
}

// The graph's states as they are become the solution.
void Finish(BlockBandedCholesky normal_equations, double cost, BandedSolution* out) {
  out->summary.usable = true;
  out->summary.final_cost = cost;
  out->normal_equations = std::move(normal_equations);
}

}  // namespace

bool IsBanded(const Graph& graph) { return graph.points.empty(); }

BandedSolution SolveBanded(const SolveOptions& options, Graph* graph) {
  BandedSolution out;
  out.summary.message = "the normal equations are not positive definite";
  LinearSystem system = Linearize(*graph);
  double damping = 0;
  while (IsUsable(system) && damping < kMostDamping) {
    Damp(damping, &system.hessian);
    BlockBandedCholesky cholesky(std::move(system.hessian));
    const bool last = out.summary.iterations == options.max_iterations ||
                      (out.summary.iterations > 0 && IsUp(options.time_up));
    if (last && damping == 0) {
      if (cholesky.ok()) Finish(std::move(cholesky), system.cost, &out);
      return out;
    }
    if (cholesky.ok() && !last) {
      ++out.summary.iterations;
      const Eigen::VectorXd step = cholesky.Solve(-system.gradient);
      const double expected = -0.5 * system.gradient.dot(step);
      std::vector<GraphState> before = Retract(graph->states, step);
      std::swap(before, graph->states);
      if (damping == 0 && expected <= options.function_tolerance * system.cost + kNoDecrease) {
        Finish(std::move(cholesky), system.cost - expected, &out);
        return out;
      }
      LinearSystem next = Linearize(*graph);
      if (IsUsable(next) && next.cost <= (1 + kRounding) * system.cost) {
        system = std::move(next);
        damping = damping > 100 * kLeastDamping ? 0.01 * damping : 0;
        continue;
      }
      graph->states = std::move(before);
    }
    damping = last ? 0 : std::max(kLeastDamping, 100 * damping);
    system = Linearize(*graph);
  }
  return out;
}

}  // namespace tagtwist
