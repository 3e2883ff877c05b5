#include "estimator/window/rolling_shutter.h"

#include <gtest/gtest.h>

#include "estimator/batch/batch.h"
#include "estimator/online/config.h"
#include "estimator/start/tags_at_stamp.h"
#include "tests/support/calibration_flight.h"

namespace tagtwist {
namespace {

constexpr double kLineTimeS = 6e-5;  // 14 ms an image

// A set-up that is as configured, but for the shutter.
CalibrationFlight Flight(double line_time_s) {
  CalibrationFlightOptions options;
  options.errors = false;
  options.rows = 4;
  options.columns = 4;
  options.frames = 60;
  options.rate_hz = 30;
  options.tag_position_sigma_m = 0;
  options.tag_rotation_sigma_rad = 0;
  options.line_time_s = line_time_s;
  return DrawCalibrationFlight(options);
}

EstimatorSetup SetupOf(const CalibrationFlight& flight) {
  EstimatorOptions options = flight.config.estimator;
  options.use_tracks = false;
  return MakeEstimatorSetup(flight.config.camera, flight.config.cam_from_body, flight.config.map,
                            options);
}

double PositionRmse(const CalibrationFlight& flight, const std::vector<FrameEstimate>& frames) {
  double sum = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    sum += (frames[i].state.world_from_body.translation() - flight.world_from_body[i].translation())
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(frames.size()));
}

TEST(RollingShutter, BatchIsAsGoodAsWithoutOneOnceItIsUndone) {
  const CalibrationFlight rolling = Flight(kLineTimeS), global = Flight(0);
  const auto reference = RunBatch(SetupOf(global), global.measurements);
  ASSERT_TRUE(reference);
  BatchEstimator batch(SetupOf(rolling));
  for (const FrameMeasurements& frame : rolling.measurements) batch.Add(frame);
  const auto before = batch.Solve();
  ASSERT_TRUE(before) << before.error().message;
  batch.TakeTagsAsOfStamps(kLineTimeS, before->frames);
  const auto after = batch.Solve();
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_GT(PositionRmse(rolling, before->frames), 0.004);
  EXPECT_LT(PositionRmse(rolling, after->frames), 1.1 * PositionRmse(global, reference->frames));
  EXPECT_LT(after->noise.corner_sigma_px, 1.1 * reference->noise.corner_sigma_px);
}

// Lag 0, from the frame on where the window is full.
TEST(RollingShutter, WindowIsNearlyAsGoodAsWithoutOneOnceItIsUndone) {
  const CalibrationFlight rolling = Flight(kLineTimeS), global = Flight(0);
  const auto rmse = [](const CalibrationFlight& flight, double line_time_s) {
    const EstimatorSetup setup = SetupOf(flight);
    SlidingWindow window(setup);
    RollingShutterUndo undo(setup, line_time_s);
    double sum = 0;
    for (size_t i = 0; i < flight.measurements.size(); ++i) {
      const auto frame = undo.AsOfStamp(flight.measurements[i]);
      const auto out = window.Add(*frame);
      EXPECT_TRUE(out);
      if (i < 15) continue;
      sum += (out->current.state.world_from_body.translation() -
              flight.world_from_body[i].translation())
                 .squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(flight.measurements.size() - 15));
  };
  const double reference = rmse(global, 0);
  EXPECT_LT(rmse(rolling, kLineTimeS), 1.5 * reference);
  EXPECT_GT(rmse(rolling, 0), 3 * reference);
}

TEST(RollingShutter, StandingStillOrWithoutOneNothingMoves) {
  const CalibrationFlight flight = Flight(0);
  const std::vector<TagDetection>& tags = flight.measurements[3].tags;
  BodyState state{flight.world_from_body[3], {{1, 2, 0}, {0.5, 0, 1}}};
  const auto global = TagsAsOfStamp(SetupOf(flight), 0, state, tags);
  const auto moved = TagsAsOfStamp(SetupOf(flight), kLineTimeS, state, tags);
  state.twist = Twist();
  const auto still = TagsAsOfStamp(SetupOf(flight), kLineTimeS, state, tags);
  ASSERT_GT(tags.size(), 0u);
  for (size_t i = 0; i < tags.size(); ++i) {
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_EQ(global[i].corners[c], tags[i].corners[c]);
      EXPECT_EQ(still[i].corners[c], tags[i].corners[c]);
      EXPECT_GT((moved[i].corners[c] - tags[i].corners[c]).norm(), 0.1);
    }
  }
}

}  // namespace
}  // namespace tagtwist
