#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "estimator/batch/batch.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/online/config.h"
#include "estimator/rig/row_motion_of_tags.h"
#include "estimator/rig/tags_at_stamp.h"
#include "estimator/window/sliding_window.h"
#include "tests/support/flights/calibration_flight.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"
#include "tests/support/situations/rolling_tags.h"

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

// Undone as of another stamp, a repeated image would be another.
TEST(RollingShutter, TheWindowKnowsAnImageThatComesAgain) {
  CalibrationFlight flight = Flight(kLineTimeS);
  SlidingWindow window(flight.config.set_up, flight.config.estimator);
  size_t predicted = 0;
  for (size_t i = 0; i < flight.measurements.size(); ++i) {
    const bool again = i > 15 && i % 10 == 0;
    if (again) flight.measurements[i].tags = flight.measurements[i - 1].tags;
    const auto out = window.Add(flight.measurements[i]);
    ASSERT_TRUE(out);
    if (again) predicted += out->current.status == FrameStatus::kPredicted ? 1 : 0;
  }
  EXPECT_EQ(predicted, 4U);
  window.Finish();
  const auto warnings = window.Warnings();
  EXPECT_EQ(std::count_if(warnings.begin(), warnings.end(),
                          [](const std::string& line) {
                            return line.find("4 frames, first") != std::string::npos;
                          }),
            1)
      << testing::PrintToString(warnings);
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

// The course's mat from a body in motion, by a shutter of 20 ms.
class RowMotionTest : public testing::Test {
 protected:
  static constexpr double kSigmaPx = 0.2;

  RowMotionTest() : setup_(CourseSetup()) { setup_.line_time_s = 20e-3 / setup_.camera.height; }

  std::vector<TagDetection> See(const RowMotion& motion, unsigned seed) const {
    std::vector<TagDetection> out = SeeTags(
        setup_.map, setup_.camera, setup_.cam_from_body * Inverse(motion.at_stamp), kSigmaPx, seed);
    RollTags(
        setup_, [&](double s) { return motion.After(s); }, &out);
    return out;
  }
  std::optional<ToldRowMotion> Tell(const std::vector<TagDetection>& tags,
                                    const RowMotion* predicted) const {
    return RowMotionOfTags(setup_, kSigmaPx, tags, predicted);
  }
  // Of by_s, by how many sigmas it is off, squared.
  static double SquaredDistance(const RowMotion& a, const RowMotion& truth) {
    const PoseStep d = a.by_s - truth.by_s;
    return d.dot(a.covariance.topLeftCorner<6, 6>().ldlt().solve(d));
  }

  static RowMotion Moving(double turn, double speed) {
    RowMotion out;
    out.at_stamp = Hover({0.9, 0.9, 1.1}, 0.3, {0.1, -0.05, 0});
    out.by_s << 0.2 * turn, -0.1 * turn, turn, speed, -0.5 * speed, 0.2 * speed;
    return out;
  }
  // A sure one.
  static RowMotion Predicted(const RowMotion& motion) {
    RowMotion out = motion;
    out.covariance.topLeftCorner<6, 6>() = 1e-4 * PoseCovariance::Identity();
    return out;
  }

  EstimatorSetup setup_;
};

TEST_F(RowMotionTest, RowsExcludeAPredictionThatIsWrong) {
  constexpr double kMostChi2Of6 = 31;
  const RowMotion rest = Predicted(Moving(0, 0));
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const RowMotion truth = Moving(3, 1.5);
    const auto tags = See(truth, seed);
    for (const RowMotion* predicted : {&rest, static_cast<const RowMotion*>(nullptr)}) {
      const auto told = Tell(tags, predicted);
      ASSERT_TRUE(told);
      EXPECT_TRUE(told->excludes_prediction);
      EXPECT_LT(SquaredDistance(told->motion, truth), kMostChi2Of6);
      EXPECT_NEAR(told->motion.by_s.z(), truth.by_s.z(), 1);
    }
  }
}

TEST_F(RowMotionTest, RowsConfirmAPredictionThatIsRight) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const RowMotion& truth : {Moving(3, 1.5), Moving(0, 0)}) {
      const RowMotion predicted = Predicted(truth);
      const auto told = Tell(See(truth, seed), &predicted);
      ASSERT_TRUE(told);
      EXPECT_FALSE(told->excludes_prediction);
      EXPECT_LT((told->motion.by_s - truth.by_s).norm(), 0.05);
    }
    const auto told = Tell(See(Moving(0, 0), seed), nullptr);
    ASSERT_TRUE(told);
    EXPECT_FALSE(told->excludes_prediction);
  }
}

TEST_F(RowMotionTest, OneTagTellsNoMotionAlone) {
  auto tags = See(Moving(3, 1.5), 1);
  tags.resize(1);
  EXPECT_FALSE(Tell(tags, nullptr));
  const RowMotion rest = Predicted(Moving(0, 0));
  const auto told = Tell(tags, &rest);
  ASSERT_TRUE(told);
  EXPECT_FALSE(told->excludes_prediction);
}

TEST_F(RowMotionTest, CornersComeToAnyRowAndKnowWhatIsOpen) {
  const RowMotion truth = Moving(3, 1.5);
  const auto rolled = See(truth, 1);
  RowMotion known = truth;
  known.covariance.topLeftCorner<6, 6>() = 0.01 * PoseCovariance::Identity();
  const double after_s = 8e-3;
  const auto then = TagsAsOf(after_s, setup_, known, rolled);
  const auto seen = SeeTags(setup_.map, setup_.camera,
                            setup_.cam_from_body * Inverse(truth.After(after_s)), 0, 1);
  size_t compared = 0;
  for (const TagDetection& tag : then) {
    ASSERT_TRUE(tag.covariance);
    for (const TagDetection& exact : seen) {
      if (exact.id != tag.id) continue;
      for (size_t c = 0; c < 4; ++c) EXPECT_LT((exact.corners[c] - tag.corners[c]).norm(), 1.2);
      ++compared;
    }
  }
  EXPECT_GT(compared, 5U);
  EXPECT_TRUE(IsKnown(after_s, setup_, known, rolled));
  known.covariance *= 1e4;
  EXPECT_FALSE(IsKnown(after_s, setup_, known, rolled));
}

}  // namespace
}  // namespace tagtwist::internal::rolling_shutter_test
