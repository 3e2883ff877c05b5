#pragma once
#include <opencv2/core/mat.hpp>
#include <vector>

#include "frontend/pattern/corner_refiner.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

/// Tags that the estimator may use: in the map, once each (repeated ids are all dropped), finite,
/// all corners at least border_px inside the image. Sorted by id.
std::vector<TagDetection> FilterTags(const std::vector<TagDetection>& tags, const TagMap& map,
                                     const Camera& camera, double border_px);

/// The usable tags of an image: detected, filtered, and unless the options say not their corners
/// refined, then those found that the detector missed (CompleteTags).
std::vector<TagDetection> FindTags(const cv::Mat& gray, const TagDetector& detector,
                                   const CornerRefiner& refiner, const TagMap& map,
                                   const Camera& camera, const TagDetectorOptions& options);

}  // namespace tagtwist
