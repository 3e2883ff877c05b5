#include "estimator/window/rolling_shutter.h"

#include <optional>
#include <utility>

#include "estimator/rig/row_motion_of_tags.h"
#include "estimator/rig/tags_at_stamp.h"

namespace tagtwist::internal {

RollingShutterUndo::RollingShutterUndo(const EstimatorSetup& setup)
    : setup_(setup), of_mean_row_(setup) {}

Result<FrameMeasurements> RollingShutterUndo::AsOfStamp(FrameMeasurements measurement,
                                                        const TimeUp& time_up) {
  repeated_.TakeOut(&measurement);
  const int64_t delay_ns = MeanDelayNs(setup_, measurement.tags);
  const double delay_s = ToSeconds(delay_ns);
  const auto predicted = [&] {
    return MotionOfRows(setup_, measurement.t_ns - delay_ns,
                        [&](int64_t t_ns) { return of_mean_row_.PredictAt(t_ns); });
  };
  const auto tell = [&](const std::optional<RowMotion>& expected) {
    return RowMotionOfTags(setup_, of_mean_row_.noise().corner_sigma_px, measurement.tags,
                           expected ? &*expected : nullptr);
  };
  FrameMeasurements of_mean_row = measurement;
  const auto told = tell(predicted());
  if (told &&
      (told->excludes_prediction || IsKnown(delay_s, setup_, told->motion, measurement.tags))) {
    of_mean_row.tags = TagsAsOf(delay_s, setup_, told->motion, std::move(of_mean_row.tags));
  }
  const auto seen = of_mean_row_.Add(of_mean_row, time_up);
  if (!seen) return seen.error();
  auto motion = predicted();
  if (seen->current.status == FrameStatus::kNoFix) motion.reset();
  if (!told || told->excludes_prediction) {
    const auto again = tell(motion);
    if (again && again->excludes_prediction) motion = again->motion;
  }
  if (motion) measurement.tags = TagsAsOfStamp(setup_, *motion, measurement.tags);
  return measurement;
}

}  // namespace tagtwist::internal
