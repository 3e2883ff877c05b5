#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/online/imu/imu_feed.h"
#include "estimator/window/sliding_window.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/imu_flight.h"

namespace tagtwist::internal::imu_window_test {
namespace {

struct Rows {
  std::vector<FrameEstimate> at_arrival, at_lag;
  std::optional<ImuResult> imu;
  std::vector<std::string> warnings;
};

Rows RunWindow(const ImuFlight& flight, bool with_imu) {
  SlidingWindow window(CourseSetUp(), EstimatorOptions());
  ImuFeed feed(flight.imu, 0);
  Rows out;
  if (with_imu) window.Use(ImuOptions());
  for (const FrameMeasurements& frame : flight.measurements) {
    if (with_imu) window.AddImu(feed.Until(frame.t_ns));
    const auto step = window.Add(frame);
    EXPECT_TRUE(step);
    if (!step) return out;
    out.at_arrival.push_back(step->current);
    out.at_lag.insert(out.at_lag.end(), step->lagged.begin(), step->lagged.end());
  }
  for (const FrameEstimate& frame : window.Finish()) out.at_lag.push_back(frame);
  out.imu = window.Imu();
  out.warnings = window.Warnings();
  return out;
}

// Once its calibration is known it carries the state through gaps, at arrival and at the lag.
TEST(ImuInWindow, CarriesTheStateThroughGaps) {
  ImuFlightOptions options;
  options.duration_s = 14;
  options.gap_period_s = 5;
  options.gap_s = 1;
  const ImuFlight flight = SimulateWithImu("agile", options);
  const Rows with = RunWindow(flight, true), without = RunWindow(flight, false);
  ASSERT_TRUE(with.imu);
  EXPECT_NEAR(with.imu->gravity_world_mps2.z(), -9.81, 0.05);
  constexpr double kKnownS = 8.5;
  for (const auto rows : {&Rows::at_arrival, &Rows::at_lag}) {
    const ImuFlightErrors gap = ErrorsOf(with.*rows, flight, false, kKnownS);
    const ImuFlightErrors seen = ErrorsOf(with.*rows, flight, true, kKnownS);
    EXPECT_GT(gap.n, 20);
    EXPECT_LT(gap.largest_m, 0.05);
    EXPECT_LT(gap.nees_pose, 3);
    EXPECT_LT(gap.nees_twist, 3);
    EXPECT_GT(seen.nees_pose, 0.3);
    EXPECT_LT(seen.nees_pose, 1.7);
    EXPECT_LT(seen.nees_twist, 1.7);
  }
  const ImuFlightErrors by_tags = ErrorsOf(without.at_arrival, flight, true, kKnownS);
  const ImuFlightErrors by_both = ErrorsOf(with.at_arrival, flight, true, kKnownS);
  EXPECT_LT(by_both.velocity_mps, 0.7 * by_tags.velocity_mps);
}

// A body that is carried elsewhere while its IMU says that it rests: no state is told that the tags
// contradict.
TEST(ImuInWindow, TellsNothingThatTheTagsContradict) {
  ImuFlightOptions options;
  options.duration_s = 12;
  ImuFlight flight = SimulateWithImu("agile", options);
  const size_t at = 300;  // the frames from there on are those of another flight
  const ImuFlight other = SimulateWithImu("figure8", options);
  for (size_t i = at; i < flight.measurements.size(); ++i) {
    flight.measurements[i].tags = other.measurements[i].tags;
    flight.truth[i] = other.truth[i];
  }
  const Rows with = RunWindow(flight, true);
  ASSERT_TRUE(with.imu);
  for (const auto rows : {&with.at_arrival, &with.at_lag}) {
    for (size_t i = at; i < rows->size(); ++i) {
      if ((*rows)[i].status == FrameStatus::kNoFix) continue;
      const StateVector d = Difference((*rows)[i].state, flight.truth[i]);
      EXPECT_LT(d.segment<3>(3).norm(),
                0.05 + 6 * std::sqrt((*rows)[i].covariance.block<3, 3>(3, 3).trace()))
          << i;
    }
  }
}

// Without a sample the window is that of the tags, and says why.
TEST(ImuInWindow, IsLeftOutWhereItSaysNothing) {
  ImuFlightOptions options;
  options.duration_s = 3;
  ImuFlight flight = SimulateWithImu("figure8", options);
  flight.imu.clear();
  const Rows with = RunWindow(flight, true), without = RunWindow(flight, false);
  EXPECT_FALSE(with.imu);
  EXPECT_THAT(with.warnings, ::testing::Contains(::testing::HasSubstr("the IMU is left out")));
  ASSERT_EQ(with.at_lag.size(), without.at_lag.size());
  for (size_t i = 0; i < with.at_lag.size(); ++i) {
    EXPECT_EQ(with.at_lag[i].state.world_from_body.params,
              without.at_lag[i].state.world_from_body.params);
  }
}

}  // namespace
}  // namespace tagtwist::internal::imu_window_test
