#pragma once
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "frontend/geometry/frame_pose.h"
#include "frontend/pattern/corner_refiner.h"
#include "frontend/tags/guided_detector.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Detected and refined tags of one image, and those of the map that the detector missed: the pose
/// that most of the tags agree on (of several that they leave open, the one that shows most others)
/// says where to look, GuidedDetector whether they are there. What was detected stays, but for
/// corners that could not be refined, if they can be from where the pose says. Sorted by id. Tags
/// nearer than border_px to the image's border are left out.
std::vector<TagDetection> CompleteTags(const cv::Mat& gray, const CornerRefiner& refiner,
                                       const TagMap& map, const Camera& camera, double border_px,
                                       const RefinedTags& detected);

/// A pose of a frame with its covariance, as the tags that agree on it (`found`, for this order of
/// `tags`) say it; nullopt where they do not fix it. `guided` is of the same body as the pose.
std::optional<PosePrediction> PredictionBy(const Pose& pose, const FramePose& found,
                                           const std::vector<TagDetection>& tags, const TagMap& map,
                                           const GuidedDetector& guided);

}  // namespace tagtwist::internal
