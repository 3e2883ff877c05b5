#include "estimator/online/measure_frame.h"

#include <utility>

#include "frontend/base/spans.h"

namespace tagtwist::internal {

FrameMeasurements MeasureFrame(DetectedFrame frame, const OnlineOptions& options,
                               FrontEnd* front_end) {
  FrameMeasurements out;
  out.t_ns = frame.t_ns;
  out.tags = std::move(frame.tags);
  out.doubled_ids = std::move(frame.doubled_ids);
  const bool hurry = IsUp(options.detection_time_up);
  Stages stages(options.spans);
  stages.Next("track");
  out.tracks = front_end->Track(out.tags, hurry ? cv::Mat() : frame.image);
  out.cut_short = frame.cut_short || (hurry && !frame.image.empty());
  if (options.after_stage) options.after_stage(FrameStage::kTrack);
  stages.Next("closed form");
  out.closed_form = front_end->ClosedFormOf(out.t_ns, out.tags, out.tracks);
  if (options.after_stage) options.after_stage(FrameStage::kClosedForm);
  return out;
}

void AddCamera(const FrameMeasurements& from, FrameMeasurements* to) {
  to->tags.insert(to->tags.end(), from.tags.begin(), from.tags.end());
  to->doubled_ids.insert(to->doubled_ids.end(), from.doubled_ids.begin(), from.doubled_ids.end());
  to->cut_short = to->cut_short || from.cut_short;
  if (!to->closed_form.world_from_body) to->closed_form = from.closed_form;
}

SetUp SetUpOfCamera(const SetUp& set_up, size_t camera) {
  return {Rig{{set_up.rig.cameras.at(camera)}, set_up.rig.mounted_on}, set_up.map};
}

}  // namespace tagtwist::internal
