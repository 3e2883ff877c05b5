#include "frontend/front_end.h"

#include <opencv2/core/mat.hpp>

#include "frontend/closed_form.h"
#include "frontend/flow/klt_tracker.h"

namespace tagtwist {

using namespace internal;

struct FrontEnd::Impl {
  KltTracker tracker;
  ClosedFormEstimator closed_form;
};

FrontEnd::FrontEnd(const SetUp& set_up, const FrontEndOptions& options) {
  const RigCamera& camera = set_up.rig.front();
  impl_ = std::make_unique<Impl>(Impl{
      KltTracker(options.klt), ClosedFormEstimator(camera.camera, camera.cam_from_body, set_up.map,
                                                   options.closed_form, set_up.rig.mounted_on)});
}

FrontEnd::FrontEnd(FrontEnd&&) noexcept = default;
FrontEnd& FrontEnd::operator=(FrontEnd&&) noexcept = default;
FrontEnd::~FrontEnd() = default;

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
                                              const cv::Mat& image, const SeenBesides& besides) {
  return impl_->tracker.Track(image, tags, besides.tags_elsewhere, besides.moving_tags);
}

ClosedForm FrontEnd::ClosedFormOf(int64_t t_ns, const std::vector<TagDetection>& tags,
                                  const std::vector<TrackObservation>& tracks) {
  return impl_->closed_form.Update(t_ns, tags, tracks);
}

}  // namespace tagtwist
