#include "frontend/front_end.h"

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
  frame.closed_form = ClosedFormOf(t_ns, tags, frame.tracks);
  return frame;
}

std::vector<TrackObservation> FrontEnd::Track(const std::vector<TagDetection>& tags,
                                              const cv::Mat& image) {
  return tracker_.Track(image, tags);
}

ClosedForm FrontEnd::ClosedFormOf(int64_t t_ns, const std::vector<TagDetection>& tags,
                                  const std::vector<TrackObservation>& tracks) {
  return closed_form_.Update(t_ns, tags, tracks);
}

}  // namespace tagtwist
