#pragma once
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "frontend/base/quadratic_form.h"
#include "frontend/base/time_up.h"

namespace tagtwist::internal {

struct LeastSquaresOptions {
  int max_steps = 30;  // tried, the failed ones included
  /// Damping is a multiple of the diagonal of the normal equations: the first as long as steps
  /// lower the cost, and from the least on where they do not, times the factor at each failure and
  /// divided by it at each success. Beyond the most the search is stuck.
  double first_damping = 0, least_damping = 1e-3, most_damping = 1e9, damping_factor = 10;
  /// The step that is expected to lower the cost by no more than this share of it, plus this much,
  /// is the last one. It is taken without looking.
  double relative_tolerance = 0, absolute_tolerance = 0;
  /// So is the step after which another one would lower the cost by no more than this, if steps go
  /// on to shrink as from the last to this one.
  double tolerance_of_next = 0;
  /// By this share, and by this much, the cost may seem to rise: rounding, and what the normals
  /// neglect.
  double rounding = 0, neglected = 0;
  bool takes_any_step = false;  // whether or not it lowers the cost: plain Gauss-Newton
  TimeUp time_up = {};          // ends the search after a step
};

enum class LeastSquaresEnd {
  kConverged,
  kStepLimit,
  kTimeUp,
  kStuck,         // no damped step lowers the cost
  kNotEvaluable,  // the cost has no value where the search starts
};

/// A step, and by how much the quadratic model expects it to lower the cost.
template <typename Increment>
struct LeastSquaresStep {
  Increment dx;
  double decrease = 0;
  bool is_last = false;  // the problem's own word that it ends the search, as small steps do
};

template <typename Problem>
struct LeastSquaresResult {
  LeastSquaresEnd end = LeastSquaresEnd::kNotEvaluable;
  int steps = 0;
  typename Problem::State x;
  double cost = 0;  // half the sum of squares at x
  /// Linearised at x; where converged, at the state before the last step.
  std::optional<typename Problem::Normals> normals;

  bool converged() const { return end == LeastSquaresEnd::kConverged; }
};

/// The damped step of a form: (H + damping diag H) dx = -g. nullopt where that is not positive
/// definite.
template <int N, typename Reference>
std::optional<LeastSquaresStep<Eigen::Matrix<double, N, 1>>> DampedStep(
    const QuadraticForm<N, Reference>& form, double damping) {
  Eigen::Matrix<double, N, N> damped = form.hessian;
  damped.diagonal() *= 1 + damping;
  const Eigen::LLT<Eigen::Matrix<double, N, N>> llt(damped);
  if (llt.info() != Eigen::Success) return std::nullopt;
  LeastSquaresStep<Eigen::Matrix<double, N, 1>> out{-llt.solve(form.gradient), 0};
  out.decrease = -0.5 * form.gradient.dot(out.dx);
  return out;
}

/// Minimises half a sum of squares by Gauss-Newton, damped as by Levenberg (1944) and Marquardt
/// (1963) where a step does not lower it. A problem has
///   State, Normals                                  types; Normals has a member `cost`
///   std::optional<Normals> Linearise(const State&)  the cost and its quadratic model at a state;
///                                                   nullopt where it has no value
///   Solve(const State&, double damping, Normals*)   the step as std::optional<LeastSquaresStep>;
///                                                   nullopt where it is not determined. May use up
///                                                   the normals: the state is for making them
///                                                   anew.
///   State Step(const State&, const Increment& dx)   state [+] dx
template <typename Problem>
LeastSquaresResult<Problem> SolveLeastSquares(Problem& problem, typename Problem::State start,
                                              const LeastSquaresOptions& options) {
  const auto is_usable = [](const auto& normals) {
    return normals && normals->cost <= std::numeric_limits<double>::max();  // false where NaN
  };
  LeastSquaresResult<Problem> out;
  out.x = std::move(start);
  out.normals = problem.Linearise(out.x);
  if (!is_usable(out.normals)) return out;
  out.cost = out.normals->cost;
  double damping = options.first_damping;
  double last_decrease = 0;  // by the step that led here
  while (true) {
    out.end = LeastSquaresEnd::kStuck;
    if (damping > options.most_damping) return out;
    out.end = LeastSquaresEnd::kStepLimit;
    if (out.steps >= options.max_steps) return out;
    out.end = LeastSquaresEnd::kTimeUp;
    if (out.steps > 0 && IsUp(options.time_up)) return out;
    if (const auto step = problem.Solve(out.x, damping, &*out.normals)) {
      ++out.steps;
      typename Problem::State moved = problem.Step(out.x, step->dx);
      const double enough = options.relative_tolerance * out.cost + options.absolute_tolerance;
      const double most = (1 + options.rounding) * out.cost + options.neglected;
      const double next = last_decrease > 0 ? step->decrease * (step->decrease / last_decrease)
                                            : std::numeric_limits<double>::max();
      const bool is_small = step->decrease <= enough || next <= options.tolerance_of_next;
      if (damping <= options.first_damping && (step->is_last || is_small)) {
        out.end = LeastSquaresEnd::kConverged;
        out.x = std::move(moved);
        out.cost -= step->decrease;
        return out;
      }
      auto there = problem.Linearise(moved);
      if (is_usable(there) && (options.takes_any_step || there->cost <= most)) {
        out.x = std::move(moved);
        out.normals = std::move(there);
        out.cost = out.normals->cost;
        last_decrease = step->decrease;
        damping /= options.damping_factor;
        if (damping < options.least_damping) damping = options.first_damping;
        continue;
      }
    }
    damping = std::max(options.least_damping, options.damping_factor * damping);
  }
}

}  // namespace tagtwist::internal
