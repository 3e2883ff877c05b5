#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "estimator/calibration/calibration.h"
#include "estimator/calibration/lens/lens_kinds.h"
#include "estimator/calibration/lens/views.h"
#include "frontend/base/result.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Lenses to start from, and what is to be calibrated.
struct LensStarts {
  std::map<LensModel, Camera> cameras;  // by model
  LensModel best = LensModel::kRadialTangential;
  ViewsJudged views;                 // by the best
  std::vector<std::string> missing;  // MissingOf(views)
  std::vector<int64_t> stamps_ns;    // SpreadOver(views)
  bool map_is_learned = false;       // from the same frames: then it is refined in any case
};
/// An error where no frame shows two tags of one plane of the map.
Result<LensStarts> StartLens(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                             int width, int height);

/// A lens of which nothing was known, and how far it may be trusted.
struct LensFound {
  LensKind kind = LensKind::kPinhole;
  BesidesLens besides;  // what was refined with it: what helps frames that were left out
  Calibration calibration;
  /// Of what the lenses of the two halves differ by to what their sigmas say.
  double halves_ratio = 0;
  ViewsJudged views;
  /// What speaks against the calibration, with what would mend it, one line each.
  std::vector<std::string> missing;
  /// What the sigmas are to be multiplied by, so that they hold: what the halves differ by more
  /// than they say, and no corner counts as nearer than 0.03 px, for what a fit to pixels errs by
  /// below that is alike from image to image.
  double inflation() const;
};
/// Kind by frames that are left out, refinement, halves. The line time is refined where that helps
/// frames that are left out, the tags' poses where, besides, the focal length is known better for
/// it, by the halves; those of a learned map always. Errors: too few frames.
Result<LensFound> FindLens(const std::vector<FrameMeasurements>& frames, const TagMap& map,
                           const LensStarts& starts);

}  // namespace tagtwist::internal
