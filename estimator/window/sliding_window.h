#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimator/graph/estimator_options.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/trajectory.h"
#include "estimator/imu/imu_options.h"
#include "estimator/result/imu_result.h"
#include "estimator/result/reprojection_errors.h"
#include "estimator/window/window_output.h"
#include "frontend/base/result.h"
#include "frontend/base/time_up.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"

namespace tagtwist {

/// Fixed-lag smoother: the last `window_frames` frames are refined jointly at every new one; the
/// frame that leaves is marginalised into a prior, never dropped. Until the first tag there is no
/// state. Noise that is not given is learned when the window first fills and adapts from then on;
/// where the tags contradict that, each interval has a density of motion of its own
/// (MotionHistory).
///
/// Frames that see nothing leave no state in the window: the motion prior bridges them, until what
/// it says is worth nothing (kNoFix). A window that cannot be solved, or whose tags contradict what
/// went before in agreement with one another, starts anew from what the tags say, and tells so at
/// the end: no frame ends a run.
///
/// While the tags leave two poses open, both are followed (WindowHypothesis); a frame whose
/// attitude they leave open by more than 5 degrees is kNoFix, and so while the frames since the
/// start do not tell their states from the mirrored ones (Mirror). Tags that the motion excludes
/// are set aside; when three frames running say the same of another place, the window starts anew
/// there. Where tags are missing, covariances grow as predictions over such a time have been found
/// to err.
///
/// Under a rolling shutter each frame's tags are taken as they would have been seen at its stamp
/// (RollingShutterUndo), and there are no tracks: nothing tells in which row their points were.
class SlidingWindow {
 public:
  SlidingWindow(const SetUp& set_up, const EstimatorOptions& options);
  SlidingWindow(SlidingWindow&&) noexcept;
  SlidingWindow& operator=(SlidingWindow&&) noexcept;
  ~SlidingWindow();

  /// An IMU on the body is in the states once four or more seconds of frames with tags have told
  /// its calibration (WindowImu); frames without tags then have states by it. Before the first
  /// frame.
  void Use(const ImuOptions& imu);
  /// What it said since the last call, those around a frame before it, as far as they are there;
  /// stamps must grow.
  void AddImu(const std::vector<ImuSample>& samples);
  /// What is known of it.
  std::optional<ImuResult> Imu() const;
  /// Stamps must grow. After an error, when what is seen cannot be what the set-up says, no frame
  /// may follow.
  /// Where the time is up the state is what the iterations until then give, the noise is learned
  /// over several frames, and the state is kHurried.
  Result<WindowOutput> Add(const FrameMeasurements& measurement, const TimeUp& time_up = {});
  /// Whether all that was seen may be what the set-up says: for short recordings, at their end.
  Status CheckSetUp() const;
  /// The frames still in the window, smoothed; call at the end.
  std::vector<FrameEstimate> Finish();
  /// State at a stamp after the newest frame's, as the motion prior carries that frame's state on,
  /// with its covariance; nullopt while there is no state, or a choice of them.
  std::optional<StateAndCovariance> PredictAt(int64_t t_ns) const;
  const NoiseModel& noise() const;
  /// What the frames that left say of tags and map, one line each; after Finish all frames.
  std::vector<std::string> Warnings() const;
  /// Errors of the corners of the frames that left, by place and by tag; after Finish of all.
  ReprojectionErrorsByPlace Reprojection() const;
  /// What each camera has in it, where there are several.
  std::vector<CameraShare> Cameras() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tagtwist
