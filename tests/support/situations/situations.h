#pragma once
#include <functional>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/result/estimate.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// What happens in a recording over the course's mat.
enum class Situation {
  kSmooth,
  kRest,
  kTakeOff,    // at rest, then off
  kTrapezoid,  // jumps of the acceleration between rest and a cruise
  kStopAndGo,
  kHit,          // pushed within a twentieth of a second
  kVibration,    // of a millimetre, from some time on
  kGaps,         // of 0.1 to 20 s without a tag
  kPhantoms,     // random quads with ids of the map, few true tags
  kKidnapped,    // carried elsewhere between two frames
  kFarTag,       // one tag alone, from so far that it barely resolves the motion
  kJitter,       // stamps that scatter around a steady clock; the truth is of the exposures
  kBursts,       // stamps of a host that takes two frames at a time
  kTwin,         // two tags, one of which has a twin elsewhere, all in view
  kTwinApart,    // the same, but never both of the twins; for a while the wrong one alone
  kGantry,       // ramps of 1 to 4 m/s^2 between rest and a cruise, nearly all of the time
  kStickSlip,    // sticks, and slips on by some millimetres within tens of milliseconds
  kRepeated,     // every so often an image comes twice or more, under stamps of their own
  kNoisy,        // for a third of the time corners scatter four times as far
  kOneTag,       // stops and goes before the map's only tag
  kRolling,      // stops and goes under a rolling shutter of 20 ms
  kRollingTurn,  // under the same it turns by 2 to 6 rad/s from some time on
  kLate,         // one stamp of ten comes late, by a third of an interval in the mean
  kLoneTag,      // stops and goes over the mat, of which one and the same tag is seen
  kLoneAtTimes,  // the same; for seven frames of every 21 with another tag beside it
  kOrbit,        // swings about one tag, all that is seen, which keeps its place in the image
};
std::vector<Situation> AllSituations();
std::string NameOf(Situation situation);

/// A draw of it, 16 s long: the truth at each frame and what is seen, corners with Gaussian noise.
struct SituationDraw {
  EstimatorSetup setup;
  std::vector<BodyState> truth;
  std::vector<FrameMeasurements> measurements;
  size_t judged_from = 0;  // until then nobody can know what stamps mean
};
SituationDraw DrawSituation(Situation situation, unsigned seed, double rate_hz = 30);

/// The same before the tag alone that most frames show, which is all of the map.
SituationDraw BeforeOneTag(SituationDraw draw);

/// The state at a time [s] of a body whose pose is known at any; the twist by differences.
BodyState StateAlong(const std::function<Pose(double t)>& pose_at, double t);

/// How an estimate of it is off.
struct SituationScore {
  size_t frames = 0;   // with a state
  size_t without = 0;  // frames with two tags or more that have none
  double nees = 0;     // per degree of freedom
  double beyond = 0;   // share of frames beyond 5 sigma in attitude, position, velocity or rate
  double position_rms_m = 0, velocity_rms_mps = 0;
};
/// Of attitude, position, velocity or rate.
bool IsBeyondFiveSigma(const BodyState& truth, const FrameEstimate& frame);
SituationScore Judge(const SituationDraw& draw, const std::vector<FrameEstimate>& frames);

}  // namespace tagtwist::internal
