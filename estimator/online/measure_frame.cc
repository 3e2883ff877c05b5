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

}  // namespace tagtwist::internal
