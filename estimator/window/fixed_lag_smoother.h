#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/track_segments.h"
#include "estimator/graph/trajectory.h"
#include "estimator/result/estimate.h"
#include "estimator/result/reprojection_tally.h"
#include "estimator/result/tag_audit.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/start/frame_start.h"
#include "estimator/start/set_up_check.h"
#include "estimator/start/tag_gate.h"
#include "estimator/window/other_place.h"
#include "estimator/window/prediction_check.h"
#include "estimator/window/window_hypothesis.h"
#include "estimator/window/window_output.h"
#include "estimator/window/window_power.h"
#include "frontend/base/time_up.h"
#include "frontend/types/measurements.h"

namespace tagtwist {

/// SlidingWindow of a global shutter: what it does with a frame whose corners are all of its stamp.
class FixedLagSmoother {
 public:
  explicit FixedLagSmoother(EstimatorSetup setup);

  /// Stamps must grow. After an error, when what is seen cannot be what the set-up says
  /// (SetUpCheck), no frame may follow. Where the frames in the window have no common solution it
  /// starts anew from the newest alone, learns its noise anew, and says so among its warnings.
  /// Where the time is up the state is what the iterations until then give, the noise is learned
  /// over several frames, and the state is kHurried.
  Result<WindowOutput> Add(const FrameMeasurements& given, const TimeUp& time_up = {});
  /// Whether all that was seen may be what the set-up says: for short recordings, at their end.
  Status CheckSetUp() const { return set_up_check_.Finish(); }
  /// The frames still in the window, smoothed; call at the end.
  std::vector<FrameEstimate> Finish();
  /// State at a stamp after the newest frame's, as the motion prior carries that frame's state on,
  /// with its covariance; nullopt while there is no state, or a choice of them.
  std::optional<StateAndCovariance> PredictAt(int64_t t_ns) const;
  const NoiseModel& noise() const { return noise_; }
  /// What the frames that left say of tags and map, one line each; after Finish all frames.
  std::vector<std::string> Warnings() const;
  /// The same of their corners.
  ReprojectionErrorsByPlace Reprojection() const { return reprojection_.Errors(); }

 private:
  // What the solve does not need of a frame.
  struct Seen {
    ClosedForm closed_form;
    int n_tracks = 0;
    std::vector<TagDetection> tags;  // all of them
  };

  void AddFrame(const FrameMeasurements& measurement, const FrameStarts& starts);
  SolveOptions StepOptions(const TimeUp& time_up = {}) const;
  Status SolveAll(const TimeUp& time_up);
  Status LearnAtFirst(const TimeUp& time_up, WindowHypothesis* hypothesis);
  Status SolveOne(const TimeUp& time_up, WindowHypothesis* hypothesis);
  void CompareWithMirroredPoses();
  double GapSeconds(const WindowHypothesis& hypothesis, int state) const;
  FrameEstimate EstimateOf(int state) const;
  std::vector<FrameEstimate> EstimatesOfAll() const;
  NoiseStatistics StatisticsOfLeaving() const;
  void LearnFromLeavingState();
  void LetTheOldestLeave();
  /// All that the window holds is forgotten: what follows has nothing to do with it.
  void Break();
  /// After a failed solve: from what the newest frame's tags say, false where that is nothing. The
  /// rows of the others are those that were told when they came.
  bool StartAnew(const FrameMeasurements& measurement, const std::vector<TagDetection>& all_tags,
                 const TimeUp& time_up, WindowOutput* out);
  std::optional<std::string> RestartWarning() const;
  void Forget(size_t n_frames);

  EstimatorSetup setup_;
  SetUpCheck set_up_check_;
  TagGate gate_;
  NoiseModel noise_;
  TrackSegmenter segmenter_;
  int first_frame_ = 0;                       // in the window, counted from the first one added
  std::vector<Seen> seen_;                    // of the frames in the window
  std::vector<FrameEstimate> told_;           // of the same frames, when they came
  std::vector<WindowHypothesis> hypotheses_;  // the likeliest first; none before the first tag
  bool mirror_is_open_ = true;                // since the start
  double mirror_angle_rad_ = 0;               // the largest of the frames in the window
  double mirror_cost_of_left_ = 0;            // of the frames that left meanwhile
  OtherPlace other_place_;                    // that the latest frames tell
  std::optional<int64_t> last_tag_ns_;        // of the frames that left
  TagAudit audit_;                            // of the frames that left
  ReprojectionTally reprojection_;            // of the frames that left
  PredictionCheck prediction_check_;          // of the frames that left
  WindowPower power_;                         // of the frames that left
  NoiseStatistics statistics_;                // of the frames that left, fading
  bool has_learned_ = false;
  int frames_of_learning_ = 0;        // that were too short for it
  std::vector<int64_t> restarts_ns_;  // stamps at which it was started anew
};

}  // namespace tagtwist
