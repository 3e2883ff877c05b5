#include "estimator/solve/smoother.h"

#include <utility>

#include "estimator/graph/linear_system.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/banded_solver.h"

namespace tagtwist::internal {
namespace {

double LogDetInformation(const Graph& graph) {
  double sum = 0;
  for (const Factor& factor : graph.factors) sum += factor.LogDetInformation();
  return 0.5 * sum;
}

// By the bands where there is nothing else, by Ceres where there is or is asked for.
BandedSolution SolveGraph(Solver solver, const SolveOptions& options, Graph* graph) {
  if (solver == Solver::kAuto && IsBanded(*graph)) return SolveBanded(options, graph);
  BandedSolution out;
  out.summary = Solve(options, graph);
  if (out.summary.usable) out.normal_equations.emplace(Linearize(*graph).hessian);
  return out;
}

}  // namespace

Result<Solution> SolveAndInvert(const EstimatorSetup& setup, const NoiseModel& noise,
                                const GraphInput& input, const SolveOptions& options) {
  Solution out;
  out.graph = BuildGraph(setup, noise, input);
  BandedSolution solved = SolveGraph(setup.options.solver, options, &out.graph);
  if (!solved.summary.usable) {
    return Error{"the solver found no solution: " + solved.summary.message};
  }
  BlockBandedCholesky& cholesky = *solved.normal_equations;
  if (!cholesky.ok()) return Error{NotPositiveDefinite(cholesky, out.graph.states)};
  out.cost = solved.summary.final_cost;
  out.log_likelihood = LogDetInformation(out.graph) - out.cost - 0.5 * cholesky.LogDeterminant();
  out.covariance = std::move(cholesky).SelectedInverse();
  return out;
}

StateCovariance BodyCovariance(const BlockBandedMatrix& covariance, int state) {
  return covariance.At(state, state).topLeftCorner<12, 12>();
}

FrameEstimate WithoutState(const FrameMeasurements& measurement) {
  FrameEstimate out;
  out.t_ns = measurement.t_ns;
  out.closed_form = measurement.closed_form;
  out.n_tracks = static_cast<int>(measurement.tracks.size());
  return out;
}

FrameEstimate ToFrameEstimate(const ClosedForm& closed_form, int n_tracks, const GraphFrame& frame,
                              const StateCovariance& covariance) {
  FrameEstimate out;
  out.t_ns = frame.t_ns;
  out.status = frame.tags.empty() ? FrameStatus::kPredicted : FrameStatus::kOk;
  out.state = frame.state;
  out.covariance = covariance;
  out.closed_form = closed_form;
  out.n_tags = static_cast<int>(frame.tags.size());
  out.n_tracks = n_tracks;
  return out;
}

}  // namespace tagtwist::internal
