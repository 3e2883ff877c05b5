#pragma once
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "estimator/online/online_options.h"
#include "frontend/front_end.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"

namespace tagtwist::internal {

/// A frame whose tags are found.
struct DetectedFrame {
  int64_t t_ns = 0;
  std::vector<TagDetection> tags;
  bool cut_short = false;  // the time was up before all were looked for
  cv::Mat image;           // empty: none, or a bad one
  std::vector<int> doubled_ids = {};
  int camera = 0;  // of the rig that saw it
  SeenBesides besides = {};
};

/// Tracks and closed form of the next frame. Where detection's time is up no more is tracked:
/// tracks end. Tells the options of stages kTrack and kClosedForm, and their spans of "track" and
/// "closed form".
FrameMeasurements MeasureFrame(DetectedFrame frame, const OnlineOptions& options,
                               FrontEnd* front_end);

/// The same by the front end of the camera that saw it, of a rig's: its tracks have ids that no
/// other's have.
FrameMeasurements MeasureFrame(DetectedFrame frame, const OnlineOptions& options,
                               std::vector<FrontEnd>* front_ends);
/// What another camera measured at the same time; the closed form is that of the first that has a
/// pose.
void AddCamera(const FrameMeasurements& from, FrameMeasurements* to);

/// One camera of the rig, by its index, before the same map.
SetUp SetUpOfCamera(const SetUp& set_up, size_t camera);

}  // namespace tagtwist::internal
