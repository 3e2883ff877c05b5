#include "estimator/calibration/lens/lens_from_nothing.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "estimator/calibration/lens/lens_start.h"
#include "frontend/base/format_text.h"
#include "frontend/types/body_state.h"
#include "residuals/lens.h"

namespace tagtwist::internal {
namespace {

Result<Calibration> CalibrateLens(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                                  const KindChosen& lens, const BesidesLens& besides) {
  constexpr int kLeastFrames = 6;  // of a half
  CalibrationInput input;
  input.least_frames = kLeastFrames;
  input.kept = {CalibrationGroup::kPinhole, CalibrationGroup::kDistortion};
  if (besides.map_always) input.kept.push_back(CalibrationGroup::kMap);
  input.set_up = MakeSetUp(lens.camera, Pose(), map);
  input.options = OptionsOf(lens.kind, besides, map, frames.size());
  return Calibrate(input, frames, {});
}

// Every second of ten stretches of the recording.
std::vector<FrameMeasurements> Half(const std::vector<FrameMeasurements>& frames, size_t which) {
  constexpr size_t kStretches = 10;
  std::vector<FrameMeasurements> out;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (i * kStretches / frames.size() % 2 == which) out.push_back(frames[i]);
  }
  return out;
}

// How far two lenses are apart, in standard deviations of that difference, root mean square over
// the coefficients that both were refined in; nullopt where there is none.
std::optional<double> RatioOf(const Calibration& one, const Calibration& other) {
  const Eigen::VectorXd apart =
      LensDifference(one.set_up.rig.front().camera, other.set_up.rig.front().camera);
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(apart.size()); ++i) {
    const auto k = static_cast<size_t>(i);
    if (one.applied[k] && other.applied[k]) free.push_back(i);
  }
  if (free.empty()) return std::nullopt;
  const Eigen::VectorXd d = apart(free);
  const Eigen::MatrixXd covariance = one.covariance(free, free) + other.covariance(free, free);
  const Eigen::VectorXd weighted = covariance.ldlt().solve(d);
  return std::sqrt(std::max(0.0, d.dot(weighted)) / static_cast<double>(free.size()));
}

std::optional<double> RatioOfHalves(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                                    const KindChosen& lens, const BesidesLens& besides) {
  const auto one = CalibrateLens(Half(frames, 0), map, lens, besides);
  if (!one) return std::nullopt;
  const auto other = CalibrateLens(Half(frames, 1), map, lens, besides);
  return other ? RatioOf(*one, *other) : std::nullopt;
}

bool Helps(const Calibration& calibration, CalibrationGroup group) {
  const auto& verdicts = calibration.validation.verdicts;
  return std::any_of(verdicts.begin(), verdicts.end(), [&](const GroupVerdict& verdict) {
    return verdict.group == group && verdict.applied;
  });
}

// Whether a rolling shutter helps, and is one: none reads an image in less than a millisecond.
bool HasRollingShutter(const Calibration& calibration) {
  constexpr double kShortestS = 1e-3;
  const RigCamera& camera = calibration.set_up.rig.front();
  return Helps(calibration, CalibrationGroup::kShutter) &&
         std::abs(camera.line_time_s) * camera.camera.height > kShortestS;
}

// Whether enough of the frames have one within 0.2 s of them to tell a line time by.
bool ShowsMotion(const std::vector<FrameMeasurements>& frames) {
  constexpr double kNearS = 0.2;
  constexpr size_t kLeast = 40;  // both halves of them still make a calibration
  size_t n = 0;
  for (size_t i = 0; i + 1 < frames.size(); ++i) {
    n += ToSeconds(frames[i + 1].t_ns - frames[i].t_ns) <= kNearS ? 1 : 0;
  }
  return 2 * n >= frames.size() * 9 / 10 && 2 * n >= kLeast;
}

// What makes of the fit's corner noise one that counts no corner as nearer than 0.03 px; at
// least 1.
double CornerFloor(const LensFound& found) {
  constexpr double kLeastCornerPx = 0.03;
  const double corner_px = found.calibration.validation.refined.corner_sigma_px;
  return std::max(1.0, kLeastCornerPx / std::max(1e-6, corner_px));
}

// Relative.
double FocalSigma(const LensFound& found) {
  return found.inflation() * found.calibration.sigma(kLogFocal);
}

// What does not help frames that were left out is held in a second calibration: its prior would
// count in all sigmas.
Result<LensFound> Refined(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                          const KindChosen& lens, const BesidesLens& besides) {
  auto calibration = CalibrateLens(frames, map, lens, besides);
  if (!calibration) return calibration.error();
  LensFound out;
  out.kind = lens.kind;
  out.besides.line_time = HasRollingShutter(*calibration);
  out.besides.map_always = besides.map_always;
  out.besides.map = besides.map_always || Helps(*calibration, CalibrationGroup::kMap);
  if (out.besides.line_time != besides.line_time || out.besides.map != besides.map) {
    calibration = CalibrateLens(frames, map, lens, out.besides);
    if (!calibration) return calibration.error();
  }
  out.calibration = std::move(*calibration);
  const auto ratio = RatioOfHalves(frames, map, lens, out.besides);
  if (!ratio) return Error{"its halves alone give no lens: expected more frames"};
  out.halves_ratio = *ratio;
  return out;
}

std::vector<std::string> MissingOf(const LensFound& found) {
  constexpr double kMostFocalSigma = 0.005, kMostRatio = 4;
  std::vector<std::string> out = MissingOf(found.views);
  const double focal_sigma = FocalSigma(found);
  if (!(focal_sigma < kMostFocalSigma)) {
    out.push_back(
        Format("the focal length is known to %.2f %% only, expected %.2f %%: tilt the tags more, "
               "nearer to the camera",
               100 * focal_sigma, 100 * kMostFocalSigma));
  }
  const double ratio = found.halves_ratio / CornerFloor(found);
  if (!(ratio < kMostRatio)) {
    out.push_back(
        Format("the lenses of the recording's halves differ by %.1f sigmas: is the focus fixed, "
               "the sheet flat, the picture sharp?",
               ratio));
  }
  return out;
}

}  // namespace

double LensFound::inflation() const { return std::max(halves_ratio, CornerFloor(*this)); }

Result<LensStarts> StartLens(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                             int width, int height) {
  LensStarts out;
  std::optional<LensStart> best;
  for (const LensModel model : {LensModel::kRadialTangential, LensModel::kEquidistant}) {
    const auto start = FindLensStart(frames, map, width, height, model);
    if (!start) return Error{"no frame shows two tags of one plane of the map"};
    out.cameras[model] = start->camera;
    if (best && !(start->error_px < best->error_px)) continue;
    best = start;
    out.best = model;
  }
  out.views = JudgeViews(frames, map, best->camera);
  out.missing = MissingOf(out.views);
  out.stamps_ns = SpreadOver(out.views, frames);
  return out;
}

Result<LensFound> FindLens(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                           const LensStarts& starts) {
  BesidesLens besides;
  besides.line_time = ShowsMotion(frames);
  besides.map = besides.map_always = starts.map_is_learned;
  const auto lens = ChooseKind(frames, map, starts.cameras, starts.best, besides);
  if (!lens) return lens.error();
  auto out = Refined(frames, map, *lens, besides);
  if (!out) return out.error();
  if (!starts.map_is_learned) {
    besides = out->besides;
    besides.map = map.tags().size() > 1;
    if (auto with_map = Refined(frames, map, *lens, besides); with_map && with_map->besides.map) {
      if (FocalSigma(*with_map) < FocalSigma(*out)) out = std::move(with_map);
    }
  }
  out->views = JudgeViews(frames, map, out->calibration.set_up.rig.front().camera);
  out->missing = MissingOf(*out);
  return out;
}

}  // namespace tagtwist::internal
