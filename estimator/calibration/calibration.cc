#include "estimator/calibration/calibration.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <unordered_map>
#include <utility>

#include "estimator/calibration/solver.h"
#include "estimator/start/recording_start.h"
#include "frontend/types/truth.h"

namespace tagtwist::internal {
namespace {

constexpr double kClockSigmas = 3;  // as far as the clock may move, there is truth at hand

CalibrationState StateOf(const SetUp& set_up) {
  CalibrationState out;
  out.camera = set_up.rig.front().camera;
  out.line_time_s = set_up.rig.front().line_time_s;
  out.cam_from_body = set_up.rig.front().cam_from_body;
  out.tags = set_up.map.tags();
  return out;
}

std::vector<CalibrationFrame> MakeFrames(const CalibrationInput& input,
                                         const std::vector<GraphFrame>& starts,
                                         const std::vector<TruthSample>& truth) {
  std::unordered_map<int, int> index;
  for (const Tag& tag : input.set_up.map.tags())
    index.emplace(tag.id, static_cast<int>(index.size()));
  const Pose body_from_cam = Inverse(input.set_up.rig.front().cam_from_body);
  const double clock_sigma_s = input.options.time_offset_sigma_s;
  std::vector<CalibrationFrame> out;
  for (const GraphFrame& start : starts) {
    if (start.tags.empty()) continue;
    CalibrationFrame frame;
    frame.t_ns = start.t_ns;
    frame.world_from_cam = start.state.world_from_body * body_from_cam;
    frame.has_truth =
        HasTruthAround(truth, start.t_ns, kClockSigmas * clock_sigma_s, kMaxTruthGapS);
    std::vector<CalibrationView> views;
    for (const TagDetection& tag : start.tags) {
      CalibrationView view;
      view.tag = index.at(tag.id);
      view.pixels = tag.corners;
      if (!input.estimator.corner_sigma_px) view.covariance = tag.covariance;
      views.push_back(view);
    }
    frame.shared_views = std::make_shared<const std::vector<CalibrationView>>(std::move(views));
    out.push_back(std::move(frame));
  }
  return out;
}

// Frames whose motion is not known cannot say what a rolling shutter did to them.
void DropStandAlone(std::vector<CalibrationFrame>* frames) {
  const auto alone = [](const CalibrationFrame& frame) { return !frame.motion; };
  frames->erase(std::remove_if(frames->begin(), frames->end(), alone), frames->end());
}

// Holds what nothing is seen of.
void HoldUnseen(const std::vector<CalibrationFrame>& frames,
                const std::vector<CalibrationParameter>& parameters,
                const CalibrationLayout& layout, Eigen::VectorXd* sigmas) {
  const bool has_truth = std::any_of(frames.begin(), frames.end(),
                                     [](const CalibrationFrame& f) { return f.has_truth; });
  if (!has_truth) (*sigmas)(layout.scale()) = 0;
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (!has_truth && parameters[i].group == CalibrationGroup::kTruth) {
      (*sigmas)(static_cast<Eigen::Index>(i)) = 0;
    }
  }
  std::vector<bool> seen(static_cast<size_t>(layout.n_tags));
  for (const CalibrationFrame& frame : frames) {
    for (const CalibrationView& view : frame.views()) seen[static_cast<size_t>(view.tag)] = true;
  }
  for (int i = 0; i < layout.n_tags; ++i) {
    if (!seen[static_cast<size_t>(i)]) sigmas->segment<kTagEntries>(layout.tag(i)).setZero();
  }
}

// No shorter than half a second: errors of neighbouring frames are alike.
int BlocksFor(const CalibrationProblem& problem, int wanted) {
  constexpr double kShortestS = 0.5;
  constexpr int kFewest = 4;
  const double length_s = ToSeconds(problem.frames.back().t_ns - problem.frames.front().t_ns);
  return std::clamp(static_cast<int>(length_s / kShortestS), kFewest, wanted);
}

}  // namespace

SetUp Apply(const SetUp& set_up, const CalibrationState& state) {
  SetUp out = set_up;
  RigCamera& camera = out.rig.front();
  camera.camera = state.camera;
  camera.line_time_s = state.line_time_s;
  camera.cam_from_body = state.cam_from_body;
  const double scale = std::exp(state.log_scale);
  std::vector<Tag> tags = state.tags;
  for (Tag& tag : tags) {
    tag.size_m *= scale;
    tag.bend_m *= scale;
    const Pose scaled =
        MakePose(tag.world_from_tag.rotation(), scale * tag.world_from_tag.translation());
    tag.world_from_tag = state.truth_from_world * scaled;
  }
  out.map = TagMap(set_up.map.family(), std::move(tags));
  return out;
}

Result<CalibrationProblem> MakeCalibrationProblem(
    const CalibrationInput& input, const std::vector<FrameMeasurements>& measurements,
    const std::vector<TruthSample>& truth) {
  const RigCamera& camera = input.set_up.rig.front();
  const EstimatorSetup setup = MakeEstimatorSetup(input.set_up, input.estimator);
  const auto starts = StartFrames(setup, measurements);
  if (!starts) return starts.error();
  CalibrationProblem out;
  out.prior = StateOf(input.set_up);
  out.truth = truth;
  out.robust_scale = input.estimator.robust_scale;
  out.frames = MakeFrames(input, *starts, truth);
  UpdateMotion(&out.frames);
  if (camera.line_time_s != 0 || input.options.line_time_sigma_s > 0) {
    DropStandAlone(&out.frames);
  }
  if (static_cast<int>(out.frames.size()) < input.least_frames) {
    return Error{"a calibration needs " + std::to_string(input.least_frames) +
                 " frames with tags, got " + std::to_string(out.frames.size())};
  }
  const std::vector<CalibrationParameter> parameters = ParametersOf(out.prior, input.options);
  out.prior_sigmas.resize(static_cast<Eigen::Index>(parameters.size()));
  for (size_t i = 0; i < parameters.size(); ++i) {
    out.prior_sigmas(static_cast<Eigen::Index>(i)) = parameters[i].prior_sigma;
  }
  HoldUnseen(out.frames, parameters, LayoutOf(out.prior), &out.prior_sigmas);
  return out;
}

Result<Calibration> Calibrate(const CalibrationInput& input,
                              const std::vector<FrameMeasurements>& measurements,
                              const std::vector<TruthSample>& truth) {
  auto problem = MakeCalibrationProblem(input, measurements, truth);
  if (!problem) return problem.error();
  CalibrationNoise noise;
  noise.corner_sigma_px = input.estimator.corner_sigma_px.value_or(noise.corner_sigma_px);
  const bool learn_corners = !input.estimator.corner_sigma_px;
  const Error no_solution{"the calibration has no solution: tags fall behind the camera"};
  CalibrationSolution all = SolveAndLearnNoise(*problem, problem->prior, noise, learn_corners);
  if (!all.usable) return no_solution;

  Calibration out;
  out.given = problem->prior;
  out.parameters = ParametersOf(problem->prior, input.options);
  problem->frames = std::move(all.frames);  // where searches start from
  UpdateMotion(&problem->frames);
  SetCornerNoise(all.noise.corner_sigma_px, &problem->frames);
  out.unseen = FindUnseen(out.given, out.parameters, problem->prior_sigmas, all.covariance);
  out.validation = ValidateGroups(*problem, out.parameters, all.state, all.noise,
                                  BlocksFor(*problem, input.options.validation_blocks), input.kept);
  const CalibrationProblem applied = Restrict(*problem, out.parameters, out.validation.applied());
  CalibrationSolution solution =
      SolveAndLearnNoise(applied, OnlyFree(all.state, applied), all.noise, learn_corners);
  if (!solution.usable) return no_solution;
  Eigen::MatrixXd covariance = ConsiderCovariance(*problem, applied, solution);
  out.refined = std::move(solution.state);
  out.prior_sigmas = problem->prior_sigmas;
  for (const double sigma : applied.prior_sigmas) out.applied.push_back(sigma > 0);
  out.change = Difference(out.refined, out.given);
  out.covariance = std::move(covariance);
  out.noise = solution.noise;
  out.set_up = Apply(input.set_up, out.refined);
  out.frames = static_cast<int>(applied.frames.size());
  for (const CalibrationFrame& frame : applied.frames) {
    out.views += static_cast<int>(frame.views().size());
    out.has_truth = out.has_truth || frame.has_truth;
  }
  return out;
}

}  // namespace tagtwist::internal
