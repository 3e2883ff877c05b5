#include "estimator/smoother.h"

#include <algorithm>
#include <utility>

#include "estimator/banded_solver.h"
#include "estimator/frame_chain.h"
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

namespace {

// A round: solves under this noise, as finely as a last round must be or coarsely; leaves its
// statistics, and whether it took anything out of the problem.
struct Round {
  Result<Solution> solution;
  NoiseStatistics statistics;
  bool has_dropped = false;
};

// SolveAndLearn, by what makes a round.
template <typename MakeRound>
Result<Solution> Learn(const EstimatorOptions& options, bool is_open, const LearnOptions& learn,
                       const TimeUp& time_up, NoiseModel* noise, const MakeRound& make_round) {
  constexpr int kMaxRounds = 20;
  constexpr double kNear = 0.05;  // with less to go a round's solution may be the last
  NoiseExtrapolation extrapolation;
  double change = is_open ? 1 : 0;
  for (int i = 0; i < kMaxRounds && change >= learn.settled; ++i) {
    const bool may_be_last = change < kNear;
    Round round = make_round(*noise, may_be_last);
    if (!round.solution) return round.solution;
    const NoiseModel updated = UpdateNoise(*noise, round.statistics, options, learn.least_dof);
    change = NoiseChange(updated, *noise);
    if (may_be_last && change < learn.settled && !round.has_dropped) {
      noise->source = updated.source;
      return round.solution;
    }
    *noise = extrapolation.Next(*noise, updated);
    if (IsUp(time_up)) return round.solution;
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
  const auto round = [&](const NoiseModel& with, bool fine) -> Round {
    Round out{SolveAndInvert(setup, with, *input, fine ? options : Coarse(options)), {}, false};
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
  return Learn(setup.options, is_open, learn, options.time_up, noise, round);
}

// The same without factors; an error where it takes damped steps.
Result<Solution> LearnInChain(const EstimatorSetup& setup, const SolveOptions& options,
                              GraphInput* input, NoiseModel* noise, const LearnOptions& learn) {
  constexpr double kNeglected = 1e-2;
  FrameChain chain(setup, *input);
  const auto round = [&](const NoiseModel& with, bool fine) -> Round {
    auto solution =
        fine ? chain.Solve(with, options, 0) : chain.Solve(with, Coarse(options), kNeglected);
    if (!solution) return {Error{"no solution by full steps"}, {}, false};
    NoiseStatistics statistics = chain.Statistics(solution->covariance);
    return {std::move(*solution), statistics, false};
  };
  auto solution =
      Learn(setup.options, AnyNoiseIsOpen(setup.options), learn, options.time_up, noise, round);
  if (!solution) return solution;
  TakeStates(solution->graph, &input->frames);
  solution->graph = BuildGraph(setup, *noise, *input);
  return solution;
}

}  // namespace

Result<Solution> SolveAndLearn(const EstimatorSetup& setup, const SolveOptions& options,
                               GraphInput* input, NoiseModel* noise, const LearnOptions& learn) {
  if (FrameChain::Fits(setup, *input)) {
    NoiseModel learned = *noise;
    auto solution = LearnInChain(setup, options, input, &learned, learn);
    if (solution) {
      *noise = learned;
      return solution;
    }
  }
  return LearnInGraph(setup, options, input, noise, learn);
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
