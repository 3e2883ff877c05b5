#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/rig/tags_at_stamp.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

struct ToldRowMotion {
  RowMotion motion;
  bool excludes_prediction = false;
};

/// How a body moved while a rolling shutter took an image, by what was predicted and by the image's
/// own tags: their rows were taken one after the other, so that they tell the pose at the stamp and
/// the twist, by least squares (Gauss-Newton, tags that stand out among the others weighted down).
/// Where the tags exclude the prediction, by them alone. What they fit better or worse than corners
/// of that deviation is in the covariance. A plane that tilts looks much like one that comes nearer
/// while the rows are taken: where the tags do not decide, the motion is the one next to the
/// prediction. Without one, that is rest. One tag excludes nothing. nullopt where fewer than two
/// tags of the map are seen and nothing is predicted, or where they have no pose.
std::optional<ToldRowMotion> RowMotionOfTags(const EstimatorSetup& setup, double corner_sigma_px,
                                             const std::vector<TagDetection>& tags,
                                             const RowMotion* predicted);

}  // namespace tagtwist::internal
