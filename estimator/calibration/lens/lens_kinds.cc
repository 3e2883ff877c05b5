#include "estimator/calibration/lens/lens_kinds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "estimator/calibration/solver.h"
#include "estimator/calibration/validation.h"

namespace tagtwist::internal {
namespace {

// A kind's problem from its best fit.
struct Fitted {
  LensKind kind = LensKind::kPinhole;
  CalibrationProblem problem;
  std::vector<CalibrationParameter> parameters;
  CalibrationState state;
  double corner_sigma_px = 0;
};

// The frames and views of `base` under another lens.
CalibrationProblem WithLens(const CalibrationProblem& base, const Camera& camera,
                            const std::vector<CalibrationParameter>& parameters) {
  CalibrationProblem out = base;
  out.prior.camera = camera;
  out.prior_sigmas.resize(static_cast<Eigen::Index>(parameters.size()));
  for (size_t i = 0; i < parameters.size(); ++i) {
    out.prior_sigmas(static_cast<Eigen::Index>(i)) = parameters[i].prior_sigma;
  }
  return out;
}

std::optional<Fitted> Fit(const CalibrationProblem& base, const TagMap& map, LensKind kind,
                          const Camera& start, const BesidesLens& besides) {
  Camera camera = start;
  if (kind == LensKind::kPinhole) camera.k1 = camera.k2 = 0;
  Fitted out;
  out.kind = kind;
  CalibrationState prior = base.prior;
  prior.camera = camera;
  out.parameters = ParametersOf(prior, OptionsOf(kind, besides, map, base.frames.size()));
  out.problem = WithLens(base, camera, out.parameters);
  CalibrationSolution solution =
      SolveAndLearnNoise(out.problem, out.problem.prior, CalibrationNoise(), true);
  if (!solution.usable || solution.state.camera.Problem()) return std::nullopt;
  out.problem.frames = std::move(solution.frames);
  UpdateMotion(&out.problem.frames);
  out.state = std::move(solution.state);
  out.corner_sigma_px = solution.noise.corner_sigma_px;
  return out;
}

// In so many blocks of time are frames left out.
int ValidationBlocks(size_t n_frames) { return std::clamp(static_cast<int>(n_frames) / 3, 4, 20); }

HeldOutJudgement Judge(Fitted* fitted, double corner_sigma_px) {
  CalibrationNoise noise;
  noise.corner_sigma_px = corner_sigma_px;
  SetCornerNoise(corner_sigma_px, &fitted->problem.frames);
  const std::vector<CalibrationGroup> all(kAllCalibrationGroups.begin(),
                                          kAllCalibrationGroups.end());
  const int blocks = ValidationBlocks(fitted->problem.frames.size());
  return JudgeHeldOut(fitted->problem, fitted->parameters, all, fitted->state, noise, blocks);
}

// Whether the one costs less by more than twice the standard error over the blocks; or, where a few
// blocks outweigh the others, in so many blocks that it is no chance (a sign test, two sigmas).
bool IsClearlyBetter(const HeldOutJudgement& one, const HeldOutJudgement& other) {
  const auto n = static_cast<double>(one.block_costs.size());
  double sum = 0, squares = 0, wins = 0;
  for (size_t i = 0; i < one.block_costs.size(); ++i) {
    const double gain = other.block_costs[i] - one.block_costs[i];
    sum += gain;
    squares += gain * gain;
    wins += gain > 0 ? 1 : 0;
  }
  const double mean = sum / n;
  const double sigma = std::sqrt(std::max(0.0, squares / n - mean * mean) / (n - 1));
  return mean > 2 * sigma || (mean > 0 && wins >= 0.5 * n + std::sqrt(n));
}

}  // namespace

const char* ToString(LensKind kind) {
  switch (kind) {
    case LensKind::kPinhole:
      return "no distortion";
    case LensKind::kRadialTangential:
      return "radtan, 4 coefficients";
    case LensKind::kRational:
      return "radtan, 8 coefficients";
    case LensKind::kFisheye2:
      return "equidistant, 2 coefficients";
    case LensKind::kFisheye4:
      break;
  }
  return "equidistant, 4 coefficients";
}

LensModel ModelOf(LensKind kind) {
  return kind == LensKind::kFisheye2 || kind == LensKind::kFisheye4 ? LensModel::kEquidistant
                                                                    : LensModel::kRadialTangential;
}

CalibrationOptions OptionsOf(LensKind kind, const BesidesLens& besides, const TagMap& map,
                             size_t n_frames) {
  const bool is_radtan = ModelOf(kind) == LensModel::kRadialTangential;
  const bool is_long = kind == LensKind::kRational || kind == LensKind::kFisheye4;
  CalibrationOptions out;
  out.focal_sigma = 0.3;
  out.aspect_sigma = 0.02;
  out.principal_point_sigma = 0.08;
  out.radial_sigma = kind == LensKind::kPinhole ? 0 : 0.5;
  out.tangential_sigma = is_radtan && kind != LensKind::kPinhole ? 0.01 : 0;
  out.higher_distortion_sigma = is_long ? 0.3 : 0;
  out.line_time_sigma_s = besides.line_time ? 1e-4 : 0;
  double side_m = 0;
  for (const Tag& tag : map.tags()) side_m = std::max(side_m, tag.size_m);
  out.tag_position_sigma_m = besides.map ? 0.02 * side_m : 0;
  out.tag_rotation_sigma_rad = besides.map ? 0.03 : 0;
  out.print_scale_sigma = out.tag_bend_sigma = out.time_offset_sigma_s = 0;
  out.mount_position_sigma_m = out.mount_rotation_sigma_rad = 0;
  out.world_position_sigma_m = out.world_rotation_sigma_rad = 0;
  out.validation_blocks = ValidationBlocks(n_frames);
  return out;
}

Result<KindChosen> ChooseKind(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                              const std::map<LensModel, Camera>& starts, LensModel best,
                              const BesidesLens& besides) {
  const LensKind first =
      best == LensModel::kRadialTangential ? LensKind::kRadialTangential : LensKind::kFisheye2;
  CalibrationInput input;
  input.set_up = MakeSetUp(starts.at(best), Pose(), map);
  input.options = OptionsOf(first, besides, map, frames.size());
  input.least_frames = 12;
  const auto base = MakeCalibrationProblem(input, frames, {});
  if (!base) return base.error();
  std::vector<Fitted> fitted;
  double least_px = std::numeric_limits<double>::infinity();
  for (const LensKind kind : kAllLensKinds) {
    if (starts.count(ModelOf(kind)) == 0) continue;
    auto fit = Fit(*base, map, kind, starts.at(ModelOf(kind)), besides);
    if (!fit) continue;
    least_px = std::min(least_px, fit->corner_sigma_px);
    fitted.push_back(std::move(*fit));
  }
  const Fitted* chosen = nullptr;
  HeldOutJudgement held_out;
  for (Fitted& fit : fitted) {
    HeldOutJudgement judged = Judge(&fit, least_px);
    if (chosen != nullptr && !IsClearlyBetter(judged, held_out)) continue;
    chosen = &fit;
    held_out = std::move(judged);
  }
  if (chosen == nullptr) return Error{"no lens fits: tags fall behind the camera"};
  return KindChosen{chosen->kind, chosen->state.camera};
}

}  // namespace tagtwist::internal
