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

// From the first second on it carries the state through gaps, at arrival and at the lag.
TEST(ImuInWindow, CarriesTheStateThroughGaps) {
  ImuFlightOptions options;
  options.duration_s = 14;
  options.gap_period_s = 5;
  options.gap_s = 1;
  const ImuFlight flight = SimulateWithImu("agile", options);
  const Rows with = RunWindow(flight, true), without = RunWindow(flight, false);
  ASSERT_TRUE(with.imu);
  EXPECT_NEAR(with.imu->gravity_world_mps2.z(), -9.81, 0.05);
  constexpr double kKnownS = 1.5;
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

// One tag in view and a phone's IMU: at arrival the velocity is known three times better than by
// the tag, from soon after the first second on, and as well as is said.
TEST(ImuInWindow, SlowKnowsTheVelocityOfALoneTagsFrames) {
  ImuFlightOptions options;
  options.duration_s = 10;
  options.rate_hz = 50;
  options.gyro_noise_radps = 0.005;
  options.accel_noise_mps2 = 0.05;
  constexpr int kDraws = 3;
  double nees_pose = 0, nees_twist = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    options.seed = 70 + static_cast<uint64_t>(draw);
    options.clock_s = 0.003 * (draw - 1);
    ImuFlight flight = SimulateWithImu(draw == 2 ? "agile" : "hover", options);
    for (FrameMeasurements& frame : flight.measurements) {
      if (frame.tags.size() > 1) frame.tags.resize(1);
    }
    constexpr double kFromS = 2;
    const ImuFlightErrors with = ErrorsOf(RunWindow(flight, true).at_arrival, flight, true, kFromS);
    const ImuFlightErrors without =
        ErrorsOf(RunWindow(flight, false).at_arrival, flight, true, kFromS);
    EXPECT_LT(with.velocity_mps, without.velocity_mps / 3) << draw;
    EXPECT_LT(with.position_m, without.position_m) << draw;
    nees_pose += with.nees_pose / kDraws;
    nees_twist += with.nees_twist / kDraws;
  }
  EXPECT_GT(nees_pose, 0.3);
  EXPECT_LT(nees_pose, 2.5);
  EXPECT_GT(nees_twist, 0.5);
  EXPECT_LT(nees_twist, 2);
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
