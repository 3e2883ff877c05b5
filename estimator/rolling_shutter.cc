#include "estimator/rolling_shutter.h"

#include "estimator/seeding.h"

namespace tagtwist {

EstimatorSetup SetupOf(const Config& config) {
  EstimatorOptions options = config.estimator;
  if (config.line_time_s != 0) options.use_tracks = false;
  return MakeEstimatorSetup(config.camera, config.cam_from_body, config.map, options);
}

std::vector<TagDetection> TagsAsOfStamp(const EstimatorSetup& setup, double line_time_s,
                                        const BodyState& at_stamp, std::vector<TagDetection> tags) {
  const auto project = [&](const BodyState& state, const Eigen::Vector3d& corner,
                           Eigen::Vector2d* pixel) {
    return setup.camera.Project(setup.cam_from_body * (Inverse(state.world_from_body) * corner),
                                pixel);
  };
  for (TagDetection& tag : tags) {
    if (setup.map.Find(tag.id) == nullptr) continue;
    const auto& corners = setup.map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      const BodyState at_row = Predict(at_stamp, line_time_s * tag.corners[c].y());
      Eigen::Vector2d then, later;
      if (!project(at_stamp, corners[c], &then) || !project(at_row, corners[c], &later)) continue;
      tag.corners[c] += then - later;
    }
  }
  return tags;
}

RollingShutterUndo::RollingShutterUndo(const EstimatorSetup& setup, double line_time_s)
    : setup_(setup), line_time_s_(line_time_s), as_seen_(setup) {}

Result<FrameMeasurements> RollingShutterUndo::AsOfStamp(FrameMeasurements measurement,
                                                        const TimeUp& time_up) {
  const auto seen = as_seen_.Add(measurement, time_up);
  if (!seen) return seen.error();
  if (seen->current.status == FrameStatus::kNoFix) return measurement;
  measurement.tags = TagsAsOfStamp(setup_, line_time_s_, seen->current.state, measurement.tags);
  return measurement;
}

}  // namespace tagtwist
