#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>

#include "estimator/online/online_options.h"
#include "estimator/result/estimate.h"
#include "frontend/base/result.h"
#include "frontend/base/spans.h"
#include "frontend/types/measured_tags.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// How a recording is gone through.
struct RunOptions {
  DetectionMode detection = DetectionMode::kAuto;  // full of detections at hand
  bool sliding_window = false;
  bool use_detections = false;
  bool use_imu = false;  // the recording's, which must have one
  /// Batch: tags that were found before, with use_detections false; nullptr: images are searched.
  std::shared_ptr<const MeasuredTags> measured = {};
  /// What was measured in each frame, before or, of a window's guided detection, as it is estimated
  /// with.
  std::function<void(const FrameMeasurements&)> on_measurements = {};
  size_t max_frames = std::numeric_limits<size_t>::max();
  int64_t duration_ns = std::numeric_limits<int64_t>::max();  // from the first frame's stamp
  std::optional<double> deadline_ms;                          // of a frame, window mode
  /// Live: milliseconds since the moment of a stamp.
  std::function<double(int64_t t_ns)> age_ms;
  /// Live: how many frames were dropped so far.
  std::function<size_t()> frames_dropped;
  /// Window: of how many frames the result of the run has states, evenly spread over a longer one
  /// (RunFacts::all); 1: of none, for runs without an end, which are not finished.
  size_t most_kept = std::numeric_limits<size_t>::max();
  /// Window: a body's state at each frame (BodyNames), and the same at the window's lag, in order
  /// and as soon as it is known. An error ends the run.
  std::function<Status(size_t body, const FrameEstimate&)> on_state = {}, on_lagged = {};
  /// Told of each stage as it begins and ends; it must outlive the run. nullptr: nobody.
  SpanObserver* spans = nullptr;
  int threads = 1;       // >= 1; the result does not depend on it
  bool progress = true;  // a bar on standard error, where that is a terminal
};

}  // namespace tagtwist::internal
