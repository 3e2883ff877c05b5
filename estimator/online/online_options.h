#pragma once
#include <functional>

#include "frontend/base/for_ranges.h"
#include "frontend/base/spans.h"
#include "frontend/base/time_up.h"

namespace tagtwist {

/// How tags are found: where the window says that they are, or by searching each image. kAuto is
/// guided where cameras on the body refine patterns, else full.
enum class DetectionMode { kAuto, kFull, kGuided };

/// What is done with a frame, in this order.
enum class FrameStage { kDetect, kTrack, kClosedForm, kSolve };

/// How an online run goes about its frames.
struct OnlineOptions {
  DetectionMode detection = DetectionMode::kAuto;
  bool use_imu = false;  // OnlineEstimator::AddImu, as Config::imu says
  /// When the frame at hand must be done with, told by whoever has a clock: detection stops when
  /// the first says so and tracks end there; the solve stops when the second does.
  TimeUp detection_time_up = {}, solve_time_up = {};
  /// How the cameras of a rig are searched: their images at one time can be at once.
  ForRanges for_ranges = InOneRange;
  /// Called as each stage of a frame is done, for whoever times them; of a rig those between
  /// detection and solve once a camera.
  std::function<void(FrameStage)> after_stage = {};
  /// Told of the same stages as they begin and end; it must outlive the run. nullptr: nobody.
  SpanObserver* spans = nullptr;
};

}  // namespace tagtwist
