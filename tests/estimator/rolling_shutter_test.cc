#include <gtest/gtest.h>

#include "estimator/batch/batch.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/online/config.h"
#include "estimator/start/tags_at_stamp.h"
#include "estimator/window/sliding_window.h"
#include "tests/support/flights/calibration_flight.h"

namespace tagtwist::internal::rolling_shutter_test {
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
  CalibrationFlight flight = DrawCalibrationFlight(options);
  flight.config.set_up.rig.front().line_time_s = line_time_s;
  return flight;
}

double PositionRmse(const CalibrationFlight& flight, const std::vector<FrameEstimate>& frames) {
  double sum = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    sum += (frames[i].state.world_from_body.translation() - flight.world_from_body[i].translation())
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(frames.size()));
}

// The flight by a set-up that knows nothing of the shutter.
CalibrationFlight Unaware(CalibrationFlight flight) {
  flight.config.set_up.rig.front().line_time_s = 0;
  return flight;
}

// By the configuration alone: nothing is done here that a shutter makes necessary.
Result<Estimate> BatchOf(const CalibrationFlight& flight) {
  return RunBatch(flight.config.set_up, flight.config.estimator, flight.measurements);
}

TEST(RollingShutter, BatchFromTheSetUpAloneIsAsGoodAsWithoutOne) {
  const CalibrationFlight rolling = Flight(kLineTimeS), global = Flight(0);
  const auto reference = BatchOf(global), unaware = BatchOf(Unaware(rolling)),
             aware = BatchOf(rolling);
  ASSERT_TRUE(reference && unaware);
  ASSERT_TRUE(aware) << aware.error().message;
  EXPECT_GT(PositionRmse(rolling, unaware->frames), 0.004);
  EXPECT_LT(PositionRmse(rolling, aware->frames), 1.1 * PositionRmse(global, reference->frames));
  EXPECT_LT(aware->noise.corner_sigma_px, 1.1 * reference->noise.corner_sigma_px);
}

// Lag 0, from the frame on where the window is full.
TEST(RollingShutter, WindowFromTheSetUpAloneIsNearlyAsGoodAsWithoutOne) {
  const CalibrationFlight rolling = Flight(kLineTimeS), global = Flight(0);
  const auto rmse = [](const CalibrationFlight& flight) {
    SlidingWindow window(flight.config.set_up, flight.config.estimator);
    double sum = 0;
    for (size_t i = 0; i < flight.measurements.size(); ++i) {
      const auto out = window.Add(flight.measurements[i]);
      EXPECT_TRUE(out);
      if (i < 15) continue;
      sum += (out->current.state.world_from_body.translation() -
              flight.world_from_body[i].translation())
                 .squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(flight.measurements.size() - 15));
  };
  const double reference = rmse(global);
  EXPECT_LT(rmse(rolling), 1.5 * reference);
  EXPECT_GT(rmse(Unaware(rolling)), 3 * reference);
}

TEST(RollingShutter, StandingStillOrWithoutOneNothingMoves) {
  const CalibrationFlight flight = Flight(0);
  const std::vector<TagDetection>& tags = flight.measurements[3].tags;
  RowMotion motion;
  motion.at_stamp = flight.world_from_body[3];
  motion.by_s << 0.5, 0, 1, 1, 2, 0;
  EstimatorSetup setup = MakeEstimatorSetup(flight.config.set_up, flight.config.estimator);
  const auto global = TagsAsOfStamp(setup, motion, tags);
  setup.line_time_s = kLineTimeS;
  const auto moved = TagsAsOfStamp(setup, motion, tags);
  motion.by_s.setZero();
  const auto still = TagsAsOfStamp(setup, motion, tags);
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
}  // namespace tagtwist::internal::rolling_shutter_test
