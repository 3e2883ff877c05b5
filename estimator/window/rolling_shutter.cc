#include "estimator/window/rolling_shutter.h"

#include "estimator/start/tags_at_stamp.h"

namespace tagtwist::internal {

RollingShutterUndo::RollingShutterUndo(const EstimatorSetup& setup)
    : setup_(setup), as_seen_(setup) {}

Result<FrameMeasurements> RollingShutterUndo::AsOfStamp(FrameMeasurements measurement,
                                                        const TimeUp& time_up) {
  const auto seen = as_seen_.Add(measurement, time_up);
  if (!seen) return seen.error();
  if (seen->current.status == FrameStatus::kNoFix) return measurement;
  const auto motion = MotionOfRows(setup_, measurement.t_ns - MeanDelayNs(setup_, measurement.tags),
                                   [&](int64_t t_ns) { return as_seen_.PredictAt(t_ns); });
  if (motion) measurement.tags = TagsAsOfStamp(setup_, *motion, measurement.tags);
  return measurement;
}

}  // namespace tagtwist::internal
