#include "estimator/imu/surer_states.h"

#include <gtest/gtest.h>

#include <cmath>

#include "estimator/batch/batch.h"
#include "estimator/online/imu/imu_feed.h"
#include "estimator/window/sliding_window.h"
#include "frontend/base/statistics/random_stream.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/imu_flight.h"

namespace tagtwist::internal::surer_states_test {
namespace {

constexpr int kFirstRate = 9;

// A state at rest whose entries all have that sigma, but for the rates.
FrameEstimate With(double sigma, double sigma_of_rates) {
  FrameEstimate out;
  out.status = FrameStatus::kOk;
  out.covariance.diagonal().setConstant(sigma * sigma);
  out.covariance.diagonal().tail<3>().setConstant(sigma_of_rates * sigma_of_rates);
  return out;
}

TEST(SurerStates, TheOneThatIsKnownBetterIsTaken) {
  SurerStates states;
  FrameEstimate by_tags = With(1e-3, 1e-3), by_both = With(1e-2, 1e-2);
  by_both.state.twist.v_world.x() = 0.01;
  EXPECT_TRUE(states.Choose(by_tags, &by_both));
  EXPECT_EQ(by_both.state.twist.v_world, by_tags.state.twist.v_world);
  EXPECT_EQ(by_both.covariance, by_tags.covariance);

  by_tags = With(1e-2, 1e-2);
  by_both = With(1e-3, 1e-2);
  by_both.covariance(0, kFirstRate) = by_both.covariance(kFirstRate, 0) = 4e-6;
  by_tags.state.twist.omega_body.x() = 0.01;
  EXPECT_FALSE(states.Choose(by_tags, &by_both));
  EXPECT_EQ(by_both.covariance(3, 3), 1e-6);
  // Two measurements of the rates, alike: their mean.
  EXPECT_NEAR(by_both.state.twist.omega_body.x(), 0.005, 1e-12);
  EXPECT_NEAR(by_both.covariance(kFirstRate, kFirstRate), 0.5e-4, 1e-12);
  EXPECT_NEAR(by_both.covariance(0, kFirstRate), 2e-6, 1e-12);
}

TEST(SurerStates, NothingIsTakenOfWhatDoesNotAgree) {
  const auto expect_untouched = [](SurerStates* states, const FrameEstimate& by_tags) {
    FrameEstimate by_both = With(1e-2, 1e-2);
    EXPECT_FALSE(states->Choose(by_tags, &by_both));
    EXPECT_EQ(by_both.state.twist.omega_body, Eigen::Vector3d::Zero());
    EXPECT_EQ(by_both.covariance, With(1e-2, 1e-2).covariance);
  };
  SurerStates far_off, without_tags;
  FrameEstimate by_tags = With(1e-3, 1e-3);
  by_tags.state.twist.omega_body.x() = 0.08;
  expect_untouched(&far_off, by_tags);
  by_tags = With(1e-3, 1e-3);
  by_tags.status = FrameStatus::kPredicted;
  expect_untouched(&without_tags, by_tags);
}

// Rates that tremble by little more than the gyro's noise show over many frames, and not where they
// scatter by that noise.
TEST(SurerStates, WhatTremblesShowsOverManyFrames) {
  RandomStream random(5, 0);
  for (const double trembling : {0.0, 0.014}) {
    SurerStates states;
    int taken = 0;
    constexpr int kFrames = 200, kLearned = 60;
    for (int i = 0; i < kFrames; ++i) {
      const FrameEstimate by_tags = With(1e-3, 1e-3);
      FrameEstimate by_both = With(1e-2, 1e-2);
      for (int axis = 0; axis < 3; ++axis) {
        by_both.state.twist.omega_body(axis) = 0.01 * random.Normal() + trembling * std::sin(2 * i);
      }
      if (states.Choose(by_tags, &by_both) && i >= kLearned) ++taken;
    }
    const int most = trembling == 0 ? kFrames : (kFrames - kLearned) / 5;
    const int least = trembling == 0 ? kFrames - kLearned : 0;
    EXPECT_LE(taken, most);
    EXPECT_GE(taken, least);
  }
}

// Corners of 0.03 px tell a calm flight's motion far better than this IMU, which does not make it
// worse: in batch, at arrival and at the lag.
TEST(SurerStates, AnImuMakesNoStatesWorse) {
  ImuFlightOptions options;
  options.duration_s = 5;
  options.corner_noise_px = 0.03;
  options.seed = 31;
  const ImuFlight flight = SimulateWithImu("figure8", options);
  constexpr double kFromS = 1.5, kNoWorse = 1.05;
  const auto expect_no_worse = [&](const std::vector<FrameEstimate>& with,
                                   const std::vector<FrameEstimate>& without) {
    const ImuFlightErrors a = ErrorsOf(with, flight, true, kFromS),
                          b = ErrorsOf(without, flight, true, kFromS);
    EXPECT_LT(a.rate_radps, kNoWorse * b.rate_radps);
    EXPECT_LT(a.velocity_mps, kNoWorse * b.velocity_mps);
    EXPECT_LT(a.position_m, kNoWorse * b.position_m);
  };
  std::vector<FrameEstimate> of_batch[2], at_arrival[2], at_lag[2];
  for (const int with : {0, 1}) {
    BatchEstimator batch(CourseSetUp(), EstimatorOptions());
    SlidingWindow window(CourseSetUp(), EstimatorOptions());
    ImuFeed feed(flight.imu, 0);
    if (with == 1) batch.Use({ImuOptions(), flight.imu});
    if (with == 1) window.Use(ImuOptions());
    for (const FrameMeasurements& frame : flight.measurements) {
      batch.Add(frame);
      if (with == 1) window.AddImu(feed.Until(frame.t_ns));
      const auto step = window.Add(frame);
      ASSERT_TRUE(step);
      at_arrival[with].push_back(step->current);
      at_lag[with].insert(at_lag[with].end(), step->lagged.begin(), step->lagged.end());
    }
    for (const FrameEstimate& frame : window.Finish()) at_lag[with].push_back(frame);
    const auto solved = batch.Solve();
    ASSERT_TRUE(solved);
    EXPECT_EQ(solved->imu.has_value(), with == 1);
    EXPECT_EQ(window.Imu().has_value(), with == 1);
    of_batch[with] = solved->frames;
  }
  expect_no_worse(of_batch[1], of_batch[0]);
  expect_no_worse(at_arrival[1], at_arrival[0]);
  expect_no_worse(at_lag[1], at_lag[0]);
}

}  // namespace
}  // namespace tagtwist::internal::surer_states_test
