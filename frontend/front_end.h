#pragma once
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "frontend/closed_form.h"
#include "frontend/flow/klt_tracker.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

struct FrontEndOptions {
  TagDetectorOptions detector;
  KltOptions klt;
  ClosedFormOptions closed_form;
};

/// Images to measurements, frame after frame. Its state is what the seed's method carries over: the
/// open tracks with the previous image, the previous frame's pose and stamp, the low-pass.
/// Detection needs no state and is a call of its own (TagDetector, then FilterTags), so that a
/// caller can run it ahead. Track and ClosedFormOf are the two stages of Process, for callers that
/// time them.
class FrontEnd {
 public:
  FrontEnd(const Camera& camera, const Pose& cam_from_body, const TagMap& map,
           const FrontEndOptions& options);

  /// Measurements of the next frame from its filtered tags and its image, which may be empty (no
  /// image, or a bad one): then there are no tracks and the open ones end.
  FrameMeasurements Process(int64_t t_ns, const std::vector<TagDetection>& tags,
                            const cv::Mat& image);
  std::vector<TrackObservation> Track(const std::vector<TagDetection>& tags, const cv::Mat& image);
  ClosedForm ClosedFormOf(int64_t t_ns, const std::vector<TagDetection>& tags,
                          const std::vector<TrackObservation>& tracks);

 private:
  KltTracker tracker_;
  ClosedFormEstimator closed_form_;
};

}  // namespace tagtwist
