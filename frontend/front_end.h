#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "frontend/closed_form_options.h"
#include "frontend/flow/klt_options.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"

namespace cv {
class Mat;
}

namespace tagtwist {

struct FrontEndOptions {
  TagDetectorOptions detector;
  KltOptions klt;
  ClosedFormOptions closed_form;
};

/// What is in view besides the tags of the map in an image.
struct SeenBesides {
  size_t tags_elsewhere = 0;                   // by other cameras of a rig at the same time
  std::vector<TagDetection> moving_tags = {};  // in the image, of bodies that move about the map
};

/// Images to measurements, frame after frame. Its state is what the seed's method carries over: the
/// open tracks with the previous image, the previous frame's pose and stamp, the low-pass.
/// Detection needs no state and is a call of its own (TagDetector, then FilterTags), so that a
/// caller can run it ahead. Track and ClosedFormOf are the two stages of Process, for callers that
/// time them.
class FrontEnd {
 public:
  FrontEnd(const SetUp& set_up, const FrontEndOptions& options);
  FrontEnd(FrontEnd&&) noexcept;
  FrontEnd& operator=(FrontEnd&&) noexcept;
  ~FrontEnd();

  /// Measurements of the next frame from its filtered tags and its image, which may be empty (no
  /// image, or a bad one): then there are no tracks and the open ones end.
  FrameMeasurements Process(int64_t t_ns, const std::vector<TagDetection>& tags,
                            const cv::Mat& image);
  /// Whether an image is byte for byte the one before, of which it keeps a copy; call it once a
  /// frame. See FrameMeasurements::same_image.
  bool ShowsTheSame(const cv::Mat& image);
  std::vector<TrackObservation> Track(const std::vector<TagDetection>& tags, const cv::Mat& image,
                                      const SeenBesides& besides = {});
  ClosedForm ClosedFormOf(int64_t t_ns, const std::vector<TagDetection>& tags,
                          const std::vector<TrackObservation>& tracks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tagtwist
