#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estimator/batch/steady_clock.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/track_segments.h"
#include "estimator/graph/trajectory.h"
#include "estimator/result/estimate.h"
#include "estimator/result/tag_audit.h"
#include "estimator/solve/smoother.h"
#include "estimator/start/set_up_check.h"
#include "estimator/start/tag_gate.h"
#include "frontend/base/result.h"
#include "frontend/types/measurements.h"

namespace tagtwist {

/// All that a batch run gives.
struct BatchResult {
  std::vector<FrameEstimate> frames;  // one a frame
  Trajectory trajectory;              // to ask between the frames
  NoiseModel noise;
  std::vector<double> reprojection_px;  // distance of every accepted corner from its prediction
  ReprojectionErrorsByPlace reprojection;
  std::vector<std::string> warnings;
};

/// Refines a whole recording in one sparse problem; noise that is not given is learned from it.
/// Takes the frames one by one and keeps of each only what the problem needs.
class BatchEstimator {
 public:
  explicit BatchEstimator(EstimatorSetup setup);

  /// Stamps must grow.
  void Add(FrameMeasurements measurement);
  /// The tags from now on as they would have been seen at the frames' stamps, by the states of a
  /// solution, one a frame: undoes a rolling shutter (tags_at_stamp.h). Once; tracks stay as they
  /// are.
  void TakeTagsAsOfStamps(double line_time_s, const std::vector<FrameEstimate>& solved);
  /// Solves for all frames. An error when no frame has a usable tag, there is no solution, or what
  /// is seen cannot be what the set-up says (SetUpCheck).
  Result<BatchResult> Solve() const;

 private:
  /// Solves and learns, again and again without the tags that the solution contradicts. Leaves in
  /// `input` the states and the tags that were used.
  Result<Solution> SolveWithTrustedTags(const std::vector<int>& state_of_frame, GraphInput* input,
                                        NoiseModel* noise) const;

  /// The rows of all frames, from where the graph has them; of those that had no state in it (-1)
  /// from the trajectory.
  void FillFrames(std::vector<GraphFrame> solved, const std::vector<int>& state_of_frame,
                  const std::vector<StateCovariance>& covariances,
                  const std::optional<SteadyClock>& clock, BatchResult* out) const;
  /// How well the tags agree with that; their errors go to `out`.
  TagAudit Audit(const std::vector<GraphFrame>& solved, const std::vector<int>& state_of_frame,
                 BatchResult* out) const;

  EstimatorSetup setup_;
  TrackSegmenter segmenter_;
  SetUpCheck set_up_check_;
  Status set_up_is_right_ = Ok();  // as far as the frames say
  TagGate gate_;
  std::vector<FrameMeasurements> measurements_;  // without their tracks, and without the tags that
  std::map<size_t, std::vector<TagDetection>> refused_;  // the gate refused, by frame
  std::vector<int> n_tracks_;
};

/// BatchEstimator over measurements at hand.
Result<BatchResult> RunBatch(const EstimatorSetup& setup,
                             const std::vector<FrameMeasurements>& measurements);

}  // namespace tagtwist
