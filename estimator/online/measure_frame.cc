#include "estimator/online/measure_frame.h"

#include <algorithm>
#include <utility>

#include "frontend/base/spans.h"

namespace tagtwist::internal {

FrameMeasurements MeasureFrame(DetectedFrame frame, const OnlineOptions& options,
                               FrontEnd* front_end) {
  FrameMeasurements out;
  out.t_ns = frame.t_ns;
  out.tags = std::move(frame.tags);
  out.doubled_ids = std::move(frame.doubled_ids);
  if (front_end->ShowsTheSame(frame.image)) out.same_image = {frame.camera};
  const bool hurry = IsUp(options.detection_time_up);
  Stages stages(options.spans);
  stages.Next("track");
  out.tracks = front_end->Track(out.tags, hurry ? cv::Mat() : frame.image, frame.besides);
  out.cut_short = frame.cut_short || (hurry && !frame.image.empty());
  if (options.after_stage) options.after_stage(FrameStage::kTrack);
  stages.Next("closed form");
  out.closed_form = front_end->ClosedFormOf(out.t_ns, out.tags, out.tracks);
  if (options.after_stage) options.after_stage(FrameStage::kClosedForm);
  return out;
}

FrameMeasurements MeasureFrame(DetectedFrame frame, const OnlineOptions& options,
                               std::vector<FrontEnd>* front_ends) {
  const int camera = frame.camera;
  const auto n_cameras = static_cast<int64_t>(front_ends->size());
  FrameMeasurements out =
      MeasureFrame(std::move(frame), options, &(*front_ends)[static_cast<size_t>(camera)]);
  if (n_cameras < 2) return out;
  for (TrackObservation& track : out.tracks) {
    track.camera = camera;
    track.track_id = track.track_id * n_cameras + camera;
  }
  out.cameras = {camera};
  return out;
}

void AddCamera(const FrameMeasurements& from, FrameMeasurements* to) {
  to->tags.insert(to->tags.end(), from.tags.begin(), from.tags.end());
  to->doubled_ids.insert(to->doubled_ids.end(), from.doubled_ids.begin(), from.doubled_ids.end());
  const auto by_id = [](const TrackObservation& a, const TrackObservation& b) {
    return a.track_id < b.track_id;
  };
  to->tracks.insert(to->tracks.end(), from.tracks.begin(), from.tracks.end());
  std::sort(to->tracks.begin(), to->tracks.end(), by_id);
  to->cameras.insert(to->cameras.end(), from.cameras.begin(), from.cameras.end());
  to->same_image.insert(to->same_image.end(), from.same_image.begin(), from.same_image.end());
  to->cut_short = to->cut_short || from.cut_short;
  if (!to->closed_form.world_from_body) to->closed_form = from.closed_form;
}

SetUp SetUpOfCamera(const SetUp& set_up, size_t camera) {
  return {Rig{{set_up.rig.cameras.at(camera)}, set_up.rig.mounted_on}, set_up.map};
}

}  // namespace tagtwist::internal
