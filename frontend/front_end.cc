#include "frontend/front_end.h"

#include <cstring>
#include <opencv2/core/mat.hpp>

#include "frontend/closed_form.h"
#include "frontend/flow/klt_tracker.h"

namespace tagtwist {

using namespace internal;

namespace {

// Of one size and type. Noise ends it within the first bytes.
bool HasSameBytes(const cv::Mat& a, const cv::Mat& b) {
  const size_t bytes_a_row = static_cast<size_t>(a.cols) * a.elemSize();
  for (int row = 0; row < a.rows; ++row) {
    if (std::memcmp(a.ptr(row), b.ptr(row), bytes_a_row) != 0) return false;
  }
  return true;
}

}  // namespace

struct FrontEnd::Impl {
  KltTracker tracker;
  ClosedFormEstimator closed_form;
  cv::Mat last_image;  // a copy
};

FrontEnd::FrontEnd(const SetUp& set_up, const FrontEndOptions& options) {
  const RigCamera& camera = set_up.rig.front();
  impl_ = std::make_unique<Impl>(
      Impl{KltTracker(options.klt),
           ClosedFormEstimator(camera.camera, camera.cam_from_body, set_up.map, options.closed_form,
                               set_up.rig.mounted_on),
           {}});
}

FrontEnd::FrontEnd(FrontEnd&&) noexcept = default;
FrontEnd& FrontEnd::operator=(FrontEnd&&) noexcept = default;
FrontEnd::~FrontEnd() = default;

FrameMeasurements FrontEnd::Process(int64_t t_ns, const std::vector<TagDetection>& tags,
                                    const cv::Mat& image) {
  FrameMeasurements frame;
  frame.t_ns = t_ns;
  frame.tags = tags;
  if (ShowsTheSame(image)) frame.same_image = {0};
  frame.tracks = Track(tags, image);
  frame.closed_form = ClosedFormOf(t_ns, tags, frame.tracks);
  return frame;
}

bool FrontEnd::ShowsTheSame(const cv::Mat& image) {
  cv::Mat& last = impl_->last_image;
  const bool is_same = !image.empty() && image.size() == last.size() &&
                       image.type() == last.type() && HasSameBytes(image, last);
  if (!is_same) image.copyTo(last);
  return is_same;
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
