#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/track_segments.h"
#include "estimator/graph/trajectory.h"
#include "estimator/motion/bank/tags_alone.h"
#include "estimator/motion/open_motion_of_chain.h"
#include "estimator/motion/repeated_images.h"
#include "estimator/motion/unfollowed_motion.h"
#include "estimator/result/estimate.h"
#include "estimator/result/rig_tally.h"
#include "estimator/result/tag_audit.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/start/corner_scatter.h"
#include "estimator/start/doubled_tags.h"
#include "estimator/start/frame_start.h"
#include "estimator/start/set_up_check.h"
#include "estimator/window/other_place.h"
#include "estimator/window/prediction_check.h"
#include "estimator/window/stamp_check.h"
#include "estimator/window/window_hypothesis.h"
#include "estimator/window/window_output.h"
#include "estimator/window/window_power.h"
#include "frontend/base/time_up.h"
#include "frontend/geometry/tag_gate.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// SlidingWindow of a global shutter: what it does with a frame whose corners are all of its stamp.
class FixedLagSmoother {
 public:
  explicit FixedLagSmoother(EstimatorSetup setup);

  /// Stamps must grow. After an error, when what is seen cannot be what the set-up says
  /// (RigCheck), no frame may follow. Where the frames have no common solution, or tags that
  /// agree with one another contradict all that went before, it starts anew, and says so in its
  /// warnings. Where the time is up the state is what the iterations until then give, the noise is
  /// learned over several frames, and the state is kHurried.
  Result<WindowOutput> Add(const FrameMeasurements& given, const TimeUp& time_up = {});
  /// Whether all that was seen may be what the set-up says: for short recordings, at their end.
  Status CheckSetUp() const { return set_up_check_.Finish(); }
  /// The frames in the window leave, for the next one's times are to be read in another way; what
  /// was learned of the motion is learned anew.
  void LeaveForNewTimes(std::vector<FrameEstimate>* lagged);
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
  /// What each camera has in it, where there are several.
  std::vector<CameraShare> Cameras() const { return reprojection_.Shares(); }

 private:
  static constexpr int kFramesToSettle = 5;  // after a restart
  // A frame that saw nothing, or whose stamp cannot be.
  struct Unseen {
    int64_t t_ns = 0;
    ClosedForm closed_form;
    int n_tracks = 0;
    std::optional<PoseMeasurement> pose = {};  // that its tags say alone, under such a stamp
    double open_s = 0;                         // what such a stamp may be off by
    std::optional<Pose> elsewhere = {};        // that its tags say and the motion excludes
  };
  // What the solve does not need of a frame.
  struct Seen {
    ClosedForm closed_form;
    int n_tracks = 0;
    std::vector<TagDetection> tags;  // all of them
    std::vector<Unseen> after;       // until the next frame
    bool is_doubted = false;         // by those before it, and its tags do not agree
    bool is_told = false;            // among the lagged ones, in a gap that is longer than the lag
  };

  FrameStarts Start(const FrameMeasurements& measurement, WindowOutput* out);
  bool IsBreak(const FrameMeasurements& measurement, const FrameStarts& starts) const;
  void TakeOutranking(const FrameMeasurements& measurement, FrameStarts* starts) const;
  bool IsLeap(const FrameMeasurements& measurement, const FrameStarts& starts) const;
  std::optional<PoseMeasurement> OutOfReach(const FrameMeasurements& measurement,
                                            const FrameStarts& starts) const;
  void JudgeIds(const FrameMeasurements& measurement);
  void LeaveOutDoubled(FrameMeasurements* measurement, WindowOutput* out);
  void LeaveAll(WindowOutput* out);
  void LeaveWrongStamps(WindowOutput* out);
  bool ComesTooSoon(int64_t t_ns, WindowOutput* out);
  bool IsSudden(const FrameEstimate& frame) const;
  void StartAnew(int64_t t_ns, WindowOutput* out);
  std::optional<std::string> RestartWarning() const;
  bool IsDoubted(const GraphFrame& frame) const;
  std::optional<PoseMeasurement> PoseOutOfTime(const FrameMeasurements& measurement) const;
  void AddUnseen(const Unseen& unseen, const FrameMeasurements& measurement, WindowOutput* out);
  void TellBeforeTheGapEnds(WindowOutput* out);
  void Tell(int state, std::vector<FrameEstimate>* out) const;
  FrameEstimate EstimateOfUnseen(int state, const Unseen& unseen) const;
  bool Solve(const FrameMeasurements& measurement, const FrameStarts& starts,
             const TimeUp& time_up);
  void AddFrame(const FrameMeasurements& measurement, const FrameStarts& starts);
  void FollowMotion();
  void LetMotionVary(WindowHypothesis* hypothesis) const;
  StateVector ExcessVariances(const WindowHypothesis& hypothesis) const;
  StateCovariance OpenAtArrival(const Block& covariance) const;
  void LookForOpenMotion(bool at_all);
  void LearnWhatIsNotFollowed();
  SolveOptions StepOptions(const TimeUp& time_up = {}) const;
  Status SolveAll(const TimeUp& time_up);
  void JudgeByShape(std::vector<TagDetection>* tags);
  Status LearnAtFirst(const TimeUp& time_up, WindowHypothesis* hypothesis);
  Status BendToNewest(const TimeUp& time_up, WindowHypothesis* hypothesis);
  Status SolveOne(const TimeUp& time_up, WindowHypothesis* hypothesis);
  void CompareWithMirroredPoses();
  bool IsMirrorOpen() const;
  double GapSeconds(const WindowHypothesis& hypothesis, int state) const;
  FrameEstimate EstimateOf(int state) const;
  std::vector<FrameEstimate> EstimatesOfAll();
  NoiseStatistics StatisticsOfLeaving() const;
  void LearnFromLeavingState();
  void LetTheOldestLeave(std::vector<FrameEstimate>* lagged);
  void Forget(size_t n_frames);

  EstimatorSetup setup_;
  RigCheck set_up_check_;
  TagGate gate_;
  CornerScatter scatter_;
  std::vector<double> misfits_px_;  // of the latest frame's tags
  RepeatedImages repeated_;
  DoubledTags doubled_;
  NoiseModel noise_;
  TrackSegmenter segmenter_;
  int first_frame_ = 0;                       // in the window, counted from the first one added
  std::vector<Seen> seen_;                    // of the frames in the window
  std::vector<WindowHypothesis> hypotheses_;  // the likeliest first; none before the first tag
  bool mirror_is_open_ = true;                // since the start
  double mirror_angle_rad_ = 0;               // the largest of the frames in the window
  double mirror_cost_of_left_ = 0;            // of the frames that left meanwhile
  OtherPlace other_place_;                    // that the latest frames tell
  std::optional<int64_t> last_tag_ns_;        // of the frames that left
  TagAudit audit_;                            // of the frames that left
  RigTally reprojection_;                     // of the frames that left
  StampCheck stamps_;                         // of all frames
  bool began_too_soon_ = false;               // the window, with the latest frame
  PredictionCheck prediction_check_;          // of the frames that left
  WindowPower power_;                         // of the frames that left
  UnfollowedByWindow unfollowed_motion_;      // by the states that left
  OpenMotionOfWindow open_motion_;            // what it leaves open of the states in the window
  NoiseStatistics statistics_;                // of the frames that left, fading
  bool has_learned_ = false;
  size_t restarts_ = 0;
  std::optional<int> alone_since_restart_;  // the id of the tag that told another place
  int restarts_in_a_row_ = 0;  // each before the frames since the last one told of the motion
  int frames_since_restart_ = 0;
  int64_t first_restart_ns_ = 0;
  int frames_of_learning_ = 0;  // that were too short for it
};

}  // namespace tagtwist::internal
