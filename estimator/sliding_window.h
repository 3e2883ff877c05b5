#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/estimate.h"
#include "estimator/graph_builder.h"
#include "estimator/noise_learning.h"
#include "estimator/smoother.h"
#include "estimator/tag_audit.h"
#include "estimator/track_segments.h"
#include "estimator/trajectory.h"
#include "frontend/types/measurements.h"

namespace tagtwist {

/// What the window says when a frame comes in.
struct WindowOutput {
  FrameEstimate current;                // of the new frame, from all that came until now
  std::vector<double> reprojection_px;  // its corners' distances from their predictions
  std::optional<FrameEstimate> lagged;  // of the frame that leaves the window, smoothed
};

/// Fixed-lag smoother: the last `window_frames` frames are refined jointly at every new one; the
/// frame that leaves is marginalised into a prior, never dropped. Until the first tag there is no
/// state. Noise that is not given is learned when the window first fills and adapts from then on.
class SlidingWindow {
 public:
  explicit SlidingWindow(EstimatorSetup setup);

  /// Stamps must grow. An error when the problem cannot be solved; the window is then as it was.
  Result<WindowOutput> Add(const FrameMeasurements& measurement);
  /// The frames still in the window, smoothed; call at the end.
  std::vector<FrameEstimate> Finish();
  /// State at a stamp after the newest frame's, as the motion prior carries that frame's state on,
  /// with its covariance; nullopt while there is no state.
  std::optional<StateAndCovariance> PredictAt(int64_t t_ns) const;
  const NoiseModel& noise() const { return noise_; }
  /// What the frames that left say of tags and map, one line each; after Finish all frames.
  std::vector<std::string> Warnings() const { return audit_.Warnings(); }

 private:
  std::optional<GraphFrame> MakeFrame(const FrameMeasurements& measurement) const;
  Status SolveWindow();
  bool DropContradicted();
  FrameEstimate EstimateOf(int state) const;
  void LearnFromLeavingState();
  void MarginalizeOldest();

  EstimatorSetup setup_;
  NoiseModel noise_;
  TrackSegmenter segmenter_;
  GraphInput input_;                             // frames in the window, their prior
  std::vector<ClosedForm> closed_forms_;         // of those frames
  std::vector<int> n_tracks_;                    // of those frames
  std::vector<std::vector<TagDetection>> seen_;  // all tags of those frames
  TagAudit audit_;                               // of the frames that left
  std::optional<Solution> solution_;             // of the last Add
  NoiseStatistics statistics_;                   // of the frames that left, fading
  bool has_learned_ = false;
};

}  // namespace tagtwist
