#include "frontend/tags/find_tags.h"

#include "frontend/tags/cut_tags.h"
#include "frontend/tags/tag_completion.h"

namespace tagtwist::internal {

std::vector<TagDetection> FindTags(const cv::Mat& gray, const TagDetector& detector,
                                   const CornerRefiner& refiner, const TagMap& map,
                                   const Camera& camera, const TagDetectorOptions& options,
                                   std::vector<int>* doubled_ids) {
  const std::vector<TagDetection> detected = detector.Detect(gray);
  if (doubled_ids != nullptr) *doubled_ids = DoubledIds(detected, map);
  std::vector<TagDetection> tags = FilterTags(detected, map, camera, options.border_px);
  if (!options.refine_pattern) return tags;
  return CompleteTags(gray, refiner, map, camera, options.border_px,
                      WithoutCutTags(refiner.RefineAll(gray, tags), ImageBox(gray)));
}

}  // namespace tagtwist::internal
