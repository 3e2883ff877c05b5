#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
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

struct Errors {
  double largest_m = 0, velocity_mps = 0, nees_pose = 0, nees_twist = 0;
  int n = 0;
};

// Of frames from a time on, with tags or without.
Errors ErrorsOf(const std::vector<FrameEstimate>& frames, const ImuFlight& flight, double from_s,
                bool with_tags) {
  Errors out;
  for (size_t i = 0; i < frames.size(); ++i) {
    const FrameEstimate& frame = frames[i];
    EXPECT_EQ(frame.t_ns, flight.measurements[i].t_ns);
    if (flight.measurements[i].tags.empty() == with_tags) continue;
    if (ToSeconds(frame.t_ns - frames[0].t_ns) < from_s) continue;
    EXPECT_EQ(frame.status, with_tags ? FrameStatus::kOk : FrameStatus::kPredicted) << i;
    const StateVector d = Difference(frame.state, flight.truth[i]);
    const Eigen::Matrix<double, 6, 6> pose = frame.covariance.topLeftCorner<6, 6>(),
                                      twist = frame.covariance.bottomRightCorner<6, 6>();
    out.largest_m = std::max(out.largest_m, d.segment<3>(3).norm());
    out.velocity_mps += d.segment<3>(6).squaredNorm();
    out.nees_pose += d.head<6>().dot(pose.llt().solve(d.head<6>())) / 6;
    out.nees_twist += d.tail<6>().dot(twist.llt().solve(d.tail<6>())) / 6;
    ++out.n;
  }
  out.velocity_mps = std::sqrt(out.velocity_mps / out.n);
  out.nees_pose /= out.n;
  out.nees_twist /= out.n;
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
    const Errors gap = ErrorsOf(with.*rows, flight, kKnownS, false);
    const Errors seen = ErrorsOf(with.*rows, flight, kKnownS, true);
    EXPECT_GT(gap.n, 20);
    EXPECT_LT(gap.largest_m, 0.05);
    EXPECT_LT(gap.nees_pose, 3);
    EXPECT_LT(gap.nees_twist, 3);
    EXPECT_GT(seen.nees_pose, 0.3);
    EXPECT_LT(seen.nees_pose, 1.7);
    EXPECT_LT(seen.nees_twist, 1.7);
  }
  const Errors by_tags = ErrorsOf(without.at_arrival, flight, kKnownS, true);
  const Errors by_both = ErrorsOf(with.at_arrival, flight, kKnownS, true);
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
