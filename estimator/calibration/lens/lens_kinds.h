#pragma once
#include <array>
#include <map>
#include <vector>

#include "estimator/calibration/calibration.h"
#include "frontend/base/result.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Lenses that are tried, in the order of preference where frames left out do not tell.
enum class LensKind { kPinhole, kRadialTangential, kFisheye2, kFisheye4, kRational };
inline constexpr std::array kAllLensKinds = {LensKind::kPinhole, LensKind::kRadialTangential,
                                             LensKind::kFisheye2, LensKind::kFisheye4,
                                             LensKind::kRational};
/// "radtan, 4 coefficients"
const char* ToString(LensKind kind);
LensModel ModelOf(LensKind kind);

/// What of the set-up is refined besides the lens.
struct BesidesLens {
  bool line_time = false;   // of frames whose motion their neighbours tell
  bool map = false;         // poses of the tags
  bool map_always = false;  // whatever they help: the map was learned from the same frames
};

/// Priors that hold nothing of the lens but what the kind leaves out, and everything else that is
/// not asked for.
CalibrationOptions OptionsOf(LensKind kind, const BesidesLens& besides, const TagMap& map,
                             size_t n_frames);

/// A kind, with the lens of that kind that fits all frames best.
struct KindChosen {
  LensKind kind = LensKind::kPinhole;
  Camera camera;
};
/// The first kind that no later one surpasses by more than twice the standard error of what it
/// gains on frames that neither was fitted to. All kinds see the same corners: those that agree
/// under `best`. `starts`: by model. Errors: MakeCalibrationProblem's.
Result<KindChosen> ChooseKind(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                              const std::map<LensModel, Camera>& starts, LensModel best,
                              const BesidesLens& besides);

}  // namespace tagtwist::internal
