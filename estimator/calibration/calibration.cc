#include "estimator/calibration/calibration.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <unordered_map>
#include <utility>

#include "estimator/calibration/sigmas.h"
#include "estimator/calibration/solver.h"
#include "estimator/start/recording_start.h"
#include "frontend/geometry/hand_eye_start.h"
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

std::vector<CalibrationFrame> MakeFrames(const Pose& cam_from_body, const CalibrationInput& input,
                                         const std::vector<GraphFrame>& starts,
                                         const std::vector<TruthSample>& truth) {
  std::unordered_map<int, int> index;
  for (const Tag& tag : input.set_up.map.tags())
    index.emplace(tag.id, static_cast<int>(index.size()));
  const Pose body_from_cam = Inverse(cam_from_body);
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

// That state as a set-up, its map in the world that the state's tags are in.
SetUp InOwnWorld(const SetUp& set_up, const CalibrationState& state) {
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
    tag.world_from_tag =
        MakePose(tag.world_from_tag.rotation(), scale * tag.world_from_tag.translation());
  }
  out.map = TagMap(set_up.map.family(), std::move(tags));
  return out;
}

size_t CountViews(const std::vector<CalibrationFrame>& frames) {
  size_t out = 0;
  for (const CalibrationFrame& frame : frames) out += frame.views().size();
  return out;
}

// The frames as they start from a set-up: with the tags that agree in it.
Result<std::vector<CalibrationFrame>> StartFrom(const SetUp& set_up, const CalibrationInput& input,
                                                const std::vector<FrameMeasurements>& measurements,
                                                const std::vector<TruthSample>& truth) {
  const auto starts = StartFrames(MakeEstimatorSetup(set_up, input.estimator), measurements);
  if (!starts) return starts.error();
  std::vector<CalibrationFrame> out =
      MakeFrames(set_up.rig.front().cam_from_body, input, *starts, truth);
  UpdateMotion(&out);
  if (input.set_up.rig.front().line_time_s != 0 || input.options.line_time_sigma_s > 0) {
    DropStandAlone(&out);
  }
  return out;
}

// Solves, and once more with the tags that agree in what was found, as long as these grow: a set-up
// that is far off agrees with few of its tags, and those are not the ones that would tell it.
CalibrationSolution SolveFromAnywhere(const CalibrationInput& input,
                                      const std::vector<FrameMeasurements>& measurements,
                                      CalibrationProblem* problem) {
  constexpr int kMostRestarts = 5;
  CalibrationNoise noise;
  noise.corner_sigma_px = input.estimator.corner_sigma_px.value_or(noise.corner_sigma_px);
  const bool learn_corners = !input.estimator.corner_sigma_px;
  CalibrationSolution out = SolveAndLearnNoise(*problem, problem->prior, noise, learn_corners);
  for (int k = 0; out.usable && k < kMostRestarts; ++k) {
    const SetUp found = InOwnWorld(input.set_up, out.state);
    auto frames = StartFrom(found, input, measurements, problem->truth);
    if (!frames || CountViews(*frames) <= CountViews(problem->frames)) break;
    problem->frames = std::move(*frames);
    out = SolveAndLearnNoise(*problem, out.state, out.noise, learn_corners);
  }
  return out;
}

// The frames' poses, and the ground truth's where it has any.
std::pair<std::vector<Pose>, std::vector<Pose>> BothPaths(const CalibrationProblem& problem) {
  std::pair<std::vector<Pose>, std::vector<Pose>> out;
  for (const CalibrationFrame& frame : problem.frames) {
    if (!frame.has_truth) continue;
    const auto at = InterpolateTruth(problem.truth, frame.t_ns, problem.max_truth_gap_s);
    if (!at) continue;
    out.first.push_back(frame.world_from_cam);
    out.second.push_back(at->world_from_body);
  }
  return out;
}

// A mount and a world that are free, but far from where they are found from nothing, are believed
// to be there: a search from where they were would not reach them.
void RecentreMount(CalibrationProblem* problem) {
  constexpr double kFarSigmas = 5;
  const CalibrationLayout layout = LayoutOf(problem->prior);
  const Eigen::VectorXd sigmas = problem->prior_sigmas.segment<12>(layout.mount());
  if (!(sigmas.array() > 0).all()) return;
  const auto [cams, bodies] = BothPaths(*problem);
  const auto found = FindHandEyeStart(cams, bodies);
  if (!found) return;
  CalibrationState there = problem->prior;
  there.cam_from_body = found->cam_from_body;
  there.truth_from_world = found->truth_from_world;
  const Eigen::VectorXd off = Difference(there, problem->prior).segment<12>(layout.mount());
  if (off.cwiseQuotient(sigmas).cwiseAbs().maxCoeff() > kFarSigmas) problem->prior = there;
}

bool IsRecentred(const CalibrationProblem& problem, const SetUp& set_up) {
  return problem.prior.cam_from_body.params != set_up.rig.front().cam_from_body.params;
}

// What the frames say of the configured set-up.
HeldOutJudgement JudgeAsConfigured(CalibrationProblem problem, const Calibration& calibration,
                                   const CalibrationNoise& noise) {
  problem.prior = calibration.given;
  const auto blocks = static_cast<int>(calibration.validation.given.block_costs.size());
  return JudgeHeldOut(problem, calibration.parameters, {}, problem.prior, noise, blocks);
}

// What follows from the refined state.
void Tell(const SetUp& given, const CalibrationProblem& applied, Calibration* out) {
  for (const double sigma : applied.prior_sigmas) out->applied.push_back(sigma > 0);
  out->change = Difference(out->refined, out->given);
  out->set_up = Apply(given, out->refined);
  RigCamera& camera = out->set_up.rig.front();
  camera.covariance = CameraCovariance(out->refined, {out->covariance, out->prior_sigmas, false},
                                       given.rig.front().covariance);
  out->frames = static_cast<int>(applied.frames.size());
  for (const CalibrationFrame& frame : applied.frames) {
    out->views += static_cast<int>(frame.views().size());
    out->has_truth = out->has_truth || frame.has_truth;
  }
}

}  // namespace

SetUp Apply(const SetUp& set_up, const CalibrationState& state) {
  SetUp out = InOwnWorld(set_up, state);
  std::vector<Tag> tags = out.map.tags();
  for (Tag& tag : tags) tag.world_from_tag = state.truth_from_world * tag.world_from_tag;
  out.map = TagMap(set_up.map.family(), std::move(tags));
  return out;
}

Result<CalibrationProblem> MakeCalibrationProblem(
    const CalibrationInput& input, const std::vector<FrameMeasurements>& measurements,
    const std::vector<TruthSample>& truth) {
  auto frames = StartFrom(input.set_up, input, measurements, truth);
  if (!frames) return frames.error();
  CalibrationProblem out;
  out.prior = StateOf(input.set_up);
  out.truth = truth;
  out.robust_scale = input.estimator.robust_scale;
  out.frames = std::move(*frames);
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
  RecentreMount(&out);
  return out;
}

Result<Calibration> Calibrate(const CalibrationInput& input,
                              const std::vector<FrameMeasurements>& measurements,
                              const std::vector<TruthSample>& truth) {
  auto problem = MakeCalibrationProblem(input, measurements, truth);
  if (!problem) return problem.error();
  const bool learn_corners = !input.estimator.corner_sigma_px;
  const Error no_solution{"the calibration has no solution: tags fall behind the camera"};
  CalibrationSolution all = SolveFromAnywhere(input, measurements, &*problem);
  if (!all.usable) return no_solution;

  Calibration out;
  out.given = problem->prior;
  out.given.cam_from_body = input.set_up.rig.front().cam_from_body;
  out.given.truth_from_world = Pose();
  out.parameters = ParametersOf(problem->prior, input.options);
  problem->frames = std::move(all.frames);  // where searches start from
  UpdateMotion(&problem->frames);
  SetCornerNoise(all.noise.corner_sigma_px, &problem->frames);
  all.frames = problem->frames;
  out.unseen = FindUnseen(out.given, out.parameters, problem->prior_sigmas, all.covariance);
  out.validation = ValidateGroups(*problem, out.parameters, all.state, all.noise,
                                  BlocksFor(*problem, input.options.validation_blocks), input.kept);
  if (IsRecentred(*problem, input.set_up)) {
    out.validation.given = JudgeAsConfigured(*problem, out, all.noise);
  }
  const CalibrationProblem applied = Restrict(*problem, out.parameters, out.validation.applied());
  CalibrationSolution solution =
      SolveAndLearnNoise(applied, OnlyFree(all.state, applied), all.noise, learn_corners);
  if (!solution.usable) return no_solution;
  out.refined = std::move(solution.state);
  out.prior_sigmas = problem->prior_sigmas;
  out.covariance =
      AboutRefined(BlockCovariance(*problem, all), out.refined, all.state, out.prior_sigmas);
  out.noise = solution.noise;
  Tell(input.set_up, applied, &out);
  return out;
}

}  // namespace tagtwist::internal
