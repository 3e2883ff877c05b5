#pragma once
#include <opencv2/core/mat.hpp>
#include <vector>

#include "frontend/pattern/corner_refiner.h"
#include "frontend/tags/filter_tags.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// What TagFinder does, with parts at hand: several threads may share the refiner. `doubled_ids`
/// gets the DoubledIds.
std::vector<TagDetection> FindTags(const cv::Mat& gray, const TagDetector& detector,
                                   const CornerRefiner& refiner, const TagMap& map,
                                   const Camera& camera, const TagDetectorOptions& options,
                                   std::vector<int>* doubled_ids = nullptr);

}  // namespace tagtwist::internal
