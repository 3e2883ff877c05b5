#include "estimator/smoother.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "estimator/banded_solver.h"
#include "estimator/linear_system.h"
#include "estimator/noise_extrapolation.h"
#include "residuals/motion_residual.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist {
namespace {

void DropSegments(const std::vector<bool>& drop, GraphInput* input) {
  std::vector<TrackSegment> kept;
  for (size_t s = 0; s < drop.size(); ++s) {
    if (!drop[s]) kept.push_back(std::move(input->segments[s]));
  }
  input->segments = std::move(kept);
}

// Half of the log determinants of the inverse noise covariances that the residuals are whitened by.
double LogDetInformation(const Graph& graph) {
  double sum = 0;
  for (const Factor& factor : graph.factors) {
    if (factor.kind == FactorKind::kTag) {
      sum += static_cast<const TagReprojectionResidual&>(*factor.cost).LogDetInformation();
    } else if (factor.kind == FactorKind::kMotion) {
      sum += static_cast<const MotionResidual&>(*factor.cost).LogDetInformation();
    }
  }
  return 0.5 * sum;
}

// By the bands where there are nothing else, else by Ceres.
BandedSolution SolveGraph(const SolveOptions& options, Graph* graph) {
  if (IsBanded(*graph)) return SolveBanded(options, graph);
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
  BandedSolution solved = SolveGraph(options, &out.graph);
  if (!solved.summary.usable) {
    return Error{"the solver found no solution: " + solved.summary.message};
  }
  BlockBandedCholesky& cholesky = *solved.normal_equations;
  if (!cholesky.ok()) return Error{"the normal equations are not positive definite"};
  out.cost = solved.summary.final_cost;
  out.log_likelihood = LogDetInformation(out.graph) - out.cost - 0.5 * cholesky.LogDeterminant();
  out.covariance = std::move(cholesky).SelectedInverse();
  return out;
}

Result<Solution> SolveAndLearn(const EstimatorSetup& setup, const SolveOptions& options,
                               GraphInput* input, NoiseModel* noise, const LearnOptions& learn) {
  constexpr int kMaxRounds = 20;
  constexpr double kNear = 0.05;  // with less to go a round's solution may be the last
  SolveOptions coarse = options;
  coarse.function_tolerance = std::max(options.function_tolerance, 1e-4);
  const StateRange all{0, static_cast<int>(input->frames.size())};
  NoiseExtrapolation extrapolation;
  // Segments may have to go even where all noise is given.
  double change = AnyNoiseIsOpen(setup.options) || !input->segments.empty() ? 1 : 0;
  for (int round = 0; round < kMaxRounds && change >= learn.settled; ++round) {
    const bool may_be_last = change < kNear;
    auto solution = SolveAndInvert(setup, *noise, *input, may_be_last ? options : coarse);
    if (!solution) return solution;
    TakeStates(solution->graph, &input->frames);
    const NoiseModel updated = UpdateNoise(
        *noise, ComputeNoiseStatistics(solution->graph, solution->covariance, *noise, all),
        setup.options, learn.least_dof);
    change = NoiseChange(updated, *noise);
    const std::vector<bool> wrong = ContradictedSegments(solution->graph, input->segments.size());
    const bool any_wrong = std::find(wrong.begin(), wrong.end(), true) != wrong.end();
    DropSegments(wrong, input);
    if (may_be_last && change < learn.settled && !any_wrong) {
      noise->source = updated.source;
      return solution;
    }
    *noise = extrapolation.Next(*noise, updated);
    if (IsUp(options.time_up)) return solution;
  }
  auto solution = SolveAndInvert(setup, *noise, *input, options);
  if (solution) TakeStates(solution->graph, &input->frames);
  return solution;
}

std::vector<TagRef> ContradictedTags(const Graph& graph) {
  std::vector<TagRef> out;
  LinearFactor linear;
  for (const Factor& factor : graph.factors) {
    if (factor.kind != FactorKind::kTag || !LinearizeFactor(graph, factor, &linear)) continue;
    if (linear.weight < kContradictedWeight)
      out.push_back({factor.blocks.front().index, factor.source});
  }
  return out;
}

void DropTags(std::vector<TagRef> tags, std::vector<GraphFrame>* frames) {
  std::sort(tags.begin(), tags.end(), [](const TagRef& a, const TagRef& b) {
    return a.state != b.state ? a.state > b.state : a.tag > b.tag;  // from the back of each frame
  });
  for (const TagRef& ref : tags) {
    auto& of_frame = (*frames)[static_cast<size_t>(ref.state)].tags;
    of_frame.erase(of_frame.begin() + ref.tag);
  }
}

std::vector<bool> ContradictedSegments(const Graph& graph, size_t n) {
  std::vector<bool> out(n, false);
  LinearFactor linear;
  for (const Factor& factor : graph.factors) {
    if (factor.kind != FactorKind::kTrack || !LinearizeFactor(graph, factor, &linear)) continue;
    if (linear.weight < kContradictedWeight) out[static_cast<size_t>(factor.source)] = true;
  }
  return out;
}

StateCovariance BodyCovariance(const BlockBandedMatrix& covariance, int state) {
  return covariance.At(state, state).topLeftCorner<12, 12>();
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

std::vector<double> ReprojectionErrors(const EstimatorSetup& setup, const GraphFrame& frame) {
  std::vector<double> errors;
  const Pose cam_from_world = setup.cam_from_body * Inverse(frame.state.world_from_body);
  for (const TagDetection& tag : frame.tags) {
    const auto& corners = setup.map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      Eigen::Vector2d pixel;
      if (!setup.camera.Project(cam_from_world * corners[c], &pixel)) continue;
      errors.push_back((pixel - tag.corners[c]).norm());
    }
  }
  return errors;
}

}  // namespace tagtwist
