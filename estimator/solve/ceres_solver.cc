#include "estimator/solve/ceres_solver.h"

#include <ceres/ceres.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <limits>
#include <memory>

#include "residuals/pose_manifold.h"

namespace tagtwist::internal {
namespace {

// Up to this many states a dense factorisation beats a sparse one.
constexpr size_t kDenseStates = 8;
// Of the cost, relative: what is left when it changes by less is next to its rounding.
constexpr double kCeresTolerance = 1e-13;

ceres::Solver::Options MakeCeresOptions(const SolveOptions& options, Graph* graph) {
  ceres::Solver::Options out;
  out.max_num_iterations = options.max_iterations;
  out.function_tolerance =
      options.function_tolerance > 0 ? options.function_tolerance : kCeresTolerance;
  out.gradient_tolerance = 1e-12;
  out.parameter_tolerance = 1e-12;
  out.num_threads = 1;
  out.logging_type = ceres::SILENT;
  // The starts are near: begin as Gauss-Newton. Any damping that shows beside the stiff motion
  // prior would hold back frames without tags, which only the prior ties.
  out.initial_trust_region_radius = 1e16;
  out.max_trust_region_radius = 1e16;
  const bool dense = graph->states.size() <= kDenseStates;
  if (graph->points.empty()) {
    out.linear_solver_type = dense ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
    return out;
  }
  out.linear_solver_type = dense ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (auto& point : graph->points) ordering->AddElementToGroup(point.data(), 0);
  for (auto& state : graph->states) {
    ordering->AddElementToGroup(state.pose.params.data(), 1);
    ordering->AddElementToGroup(state.rates.data(), 1);
  }
  out.linear_solver_ordering = std::move(ordering);
  return out;
}

// The loss of a factor, by its whitened residual: rho(information s).
class FactorLoss final : public ceres::LossFunction {
 public:
  explicit FactorLoss(const Factor& factor)
      : information_(factor.information),
        huber_(factor.huber_delta > 0 ? factor.huber_delta : std::numeric_limits<double>::max()) {}
  void Evaluate(double squared_norm, double out[3]) const override {
    huber_.Evaluate(information_ * squared_norm, out);
    out[1] *= information_;
    out[2] *= information_ * information_;
  }

 private:
  double information_;
  ceres::HuberLoss huber_;
};

// Ends a solve where its time is up.
class StopInTime : public ceres::IterationCallback {
 public:
  explicit StopInTime(const TimeUp& time_up) : time_up_(time_up) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    return summary.iteration > 0 && IsUp(time_up_) ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                   : ceres::SOLVER_CONTINUE;
  }

 private:
  const TimeUp& time_up_;
};

// The step that Ceres' residuals and Jacobians say, in the tangents of its blocks one after the
// other; false where the normal equations have none.
bool FullStep(ceres::Problem* problem, Eigen::VectorXd* step, double* decrease) {
  double cost = 0;
  std::vector<double> gradient;
  ceres::CRSMatrix j;
  if (!problem->Evaluate({}, &cost, nullptr, &gradient, &j)) return false;
  using Rows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
  const Eigen::Map<const Rows> jacobian(j.num_rows, j.num_cols,
                                        static_cast<Eigen::Index>(j.values.size()), j.rows.data(),
                                        j.cols.data(), j.values.data());
  const Eigen::SparseMatrix<double> hessian = jacobian.transpose() * jacobian;
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> llt(hessian);
  if (llt.info() != Eigen::Success) return false;
  const Eigen::Map<const Eigen::VectorXd> g(gradient.data(),
                                            static_cast<Eigen::Index>(gradient.size()));
  *step = -llt.solve(g);
  *decrease = -0.5 * g.dot(*step);
  return true;
}

// Takes full steps until they are none or no longer shrink; at most so many.
void FinishByFullSteps(int most, ceres::Problem* problem) {
  std::vector<double*> blocks;
  problem->GetParameterBlocks(&blocks);
  double last = std::numeric_limits<double>::max(), decrease = 0;
  Eigen::VectorXd step, moved;
  for (int i = 0; i < most && FullStep(problem, &step, &decrease) && decrease < last; ++i) {
    Eigen::Index row = 0;
    for (double* block : blocks) {
      const Eigen::Index size = problem->ParameterBlockTangentSize(block);
      Eigen::Map<Eigen::VectorXd> x(block, problem->ParameterBlockSize(block));
      moved.resize(x.size());
      if (const ceres::Manifold* manifold = problem->GetManifold(block)) {
        manifold->Plus(block, &step[row], moved.data());
      } else {
        moved = x + step.segment(row, size);
      }
      x = moved;
      row += size;
    }
    if (decrease <= kNoDecrease / 100) return;
    last = decrease;
  }
}

}  // namespace

SolveSummary Solve(const SolveOptions& options, Graph* graph) {
  ceres::Problem::Options problem_options;
  problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.disable_all_safety_checks = true;
  PoseManifold manifold;
  ceres::Problem problem(problem_options);
  for (auto& state : graph->states) {
    problem.AddParameterBlock(state.pose.params.data(), 7, &manifold);
    problem.AddParameterBlock(state.rates.data(), 12);
  }
  for (auto& point : graph->points) problem.AddParameterBlock(point.data(), 2);
  std::vector<double*> parameters;
  for (const Factor& factor : graph->factors) {
    parameters.clear();
    for (const BlockRef& block : factor.blocks) parameters.push_back(graph->Parameters(block));
    const bool is_plain = factor.huber_delta == 0 && factor.information == 1;
    ceres::LossFunction* loss = is_plain ? nullptr : new FactorLoss(factor);
    problem.AddResidualBlock(factor.cost.get(), loss, parameters);
  }
  ceres::Solver::Options ceres_options = MakeCeresOptions(options, graph);
  StopInTime stop_in_time(options.time_up);
  if (options.time_up) ceres_options.callbacks.push_back(&stop_in_time);
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &problem, &summary);
  // A tag seen face-on bends the cost so much that full steps may all overshoot: more damping.
  for (const double radius : {1e8, 1e5, 1e2}) {
    const bool stuck = summary.termination_type == ceres::NO_CONVERGENCE &&
                       !(summary.final_cost < summary.initial_cost);
    if (!stuck) break;
    ceres_options.initial_trust_region_radius = radius;
    ceres::Solve(ceres_options, &problem, &summary);
  }
  const bool has_end = summary.termination_type == ceres::CONVERGENCE;
  if (has_end && options.function_tolerance == 0 && graph->points.empty()) {
    FinishByFullSteps(options.max_iterations, &problem);
  }
  return {summary.IsSolutionUsable(), static_cast<int>(summary.iterations.size()),
          summary.final_cost, summary.message};
}

}  // namespace tagtwist::internal
