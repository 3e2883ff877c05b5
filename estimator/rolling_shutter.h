#pragma once
#include <vector>

#include "estimator/config.h"
#include "estimator/graph_builder.h"
#include "estimator/sliding_window.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"
#include "frontend/types/result.h"
#include "frontend/types/time_up.h"

namespace tagtwist {

/// A configuration's setup. Under a rolling shutter it is without tracks: nothing tells in which
/// row their points were.
EstimatorSetup SetupOf(const Config& config);

/// Corners of a rolling shutter's frame as they would be had the whole image been taken at its
/// stamp: each moved by the difference between its projections from the body's pose at the stamp
/// and line_time_s * v later, v its row, the body carried on by its twist. What the twist is off by
/// stays in the corners: 1 cm/s over 10 ms is 0.1 mm. Tags that the map lacks, and corners behind
/// the camera, stay as they are.
std::vector<TagDetection> TagsAsOfStamp(const EstimatorSetup& setup, double line_time_s,
                                        const BodyState& at_stamp, std::vector<TagDetection> tags);

/// Undoes a rolling shutter frame by frame, for a sliding window. The twists are those of a window
/// of its own, which takes the corners as they are: its poses are those of some row, but their
/// twist is right, and knows nothing of what is undone by it. Twists that do know feed back into
/// themselves, and run away.
class RollingShutterUndo {
 public:
  RollingShutterUndo(const EstimatorSetup& setup, double line_time_s);
  /// Stamps must grow. As it is where there is no state.
  Result<FrameMeasurements> AsOfStamp(FrameMeasurements measurement, const TimeUp& time_up = {});

 private:
  EstimatorSetup setup_;
  double line_time_s_ = 0;
  SlidingWindow as_seen_;
};

}  // namespace tagtwist
