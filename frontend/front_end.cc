#include "frontend/front_end.h"

#include <algorithm>
#include <unordered_map>

#include "frontend/tag_completion.h"

namespace tagtwist {

FrontEnd::FrontEnd(const Camera& camera, const Pose& cam_from_body, const TagMap& map,
                   const FrontEndOptions& options)
    : tracker_(options.klt), closed_form_(camera, cam_from_body, map, options.closed_form) {}

FrameMeasurements FrontEnd::Process(int64_t t_ns, const std::vector<TagDetection>& tags,
                                    const cv::Mat& image) {
  FrameMeasurements frame;
  frame.t_ns = t_ns;
  frame.tags = tags;
  frame.tracks = Track(tags, image);
  frame.closed_form = Seed(t_ns, tags, frame.tracks);
  return frame;
}

std::vector<TrackObservation> FrontEnd::Track(const std::vector<TagDetection>& tags,
                                              const cv::Mat& image) {
  return tracker_.Track(image, tags);
}

ClosedForm FrontEnd::Seed(int64_t t_ns, const std::vector<TagDetection>& tags,
                          const std::vector<TrackObservation>& tracks) {
  return closed_form_.Update(t_ns, tags, tracks);
}

std::vector<TagDetection> FilterTags(const std::vector<TagDetection>& tags, const TagMap& map,
                                     const Camera& camera, double border_px) {
  std::unordered_map<int, int> times_seen;
  for (const TagDetection& tag : tags) ++times_seen[tag.id];
  std::vector<TagDetection> usable;
  std::copy_if(tags.begin(), tags.end(), std::back_inserter(usable), [&](const TagDetection& tag) {
    // Contains() is false for a corner that is not finite.
    return map.Find(tag.id) != nullptr && times_seen[tag.id] == 1 &&
           std::all_of(tag.corners.begin(), tag.corners.end(), [&](const Eigen::Vector2d& corner) {
             return camera.Contains(corner, border_px);
           });
  });
  std::sort(usable.begin(), usable.end(),
            [](const TagDetection& a, const TagDetection& b) { return a.id < b.id; });
  return usable;
}

std::vector<TagDetection> FindTags(const cv::Mat& gray, const TagDetector& detector,
                                   const CornerRefiner& refiner, const TagMap& map,
                                   const Camera& camera, const TagDetectorOptions& options) {
  std::vector<TagDetection> tags =
      FilterTags(detector.Detect(gray), map, camera, options.border_px);
  if (!options.refine_pattern) return tags;
  return CompleteTags(gray, refiner, map, camera, options.border_px, refiner.RefineAll(gray, tags));
}

}  // namespace tagtwist
