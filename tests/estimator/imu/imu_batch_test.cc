#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/batch/batch.h"
#include "frontend/types/so3.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/imu_flight.h"

namespace tagtwist::internal::imu_batch_test {
namespace {

using ::testing::AnyOf;
using ::testing::HasSubstr;

Estimate Solve(const ImuFlight& flight, const ImuOptions* imu,
               const SetUp& set_up = CourseSetUp()) {
  BatchEstimator batch(set_up, EstimatorOptions());
  if (imu != nullptr) batch.Use({*imu, flight.imu});
  for (const FrameMeasurements& frame : flight.measurements) batch.Add(frame);
  auto out = batch.Solve();
  EXPECT_TRUE(out) << (out ? "" : out.error().message);
  return out ? std::move(*out) : Estimate();
}

// Over draws: what it finds of itself lies within its sigmas, and the states' covariances hold.
TEST(ImuInBatch, SlowFindsItsCalibrationAndKeepsItsSigmas) {
  double pose = 0, twist = 0, calibration = 0;
  constexpr int kDraws = 2;
  const char* flights[kDraws] = {"agile", "figure8"};
  for (int draw = 0; draw < kDraws; ++draw) {
    ImuFlightOptions options;
    options.seed = 20 + static_cast<uint64_t>(draw);
    options.clock_s = 0.004 * draw;
    options.accel_noise_mps2 = 0.05 * (1 + draw);
    options.duration_s = 6;
    const ImuFlight flight = SimulateWithImu(flights[draw], options);
    const ImuOptions imu;
    const Estimate with = Solve(flight, &imu);
    ASSERT_TRUE(with.imu);
    const ImuFlightErrors errors = ErrorsOf(with.frames, flight, true);
    const ImuFlightErrors without = ErrorsOf(Solve(flight, nullptr).frames, flight, true);
    EXPECT_LT(errors.position_m, 1.05 * without.position_m);
    pose += errors.nees_pose / kDraws;
    twist += errors.nees_twist / kDraws;
    const double clock = with.imu->time_offset_s - options.clock_s;
    calibration += std::pow(clock / with.imu->time_offset_sigma_s, 2) / (4 * kDraws);
    calibration +=
        with.imu->mount_rad.cwiseQuotient(with.imu->mount_sigma_rad).squaredNorm() / (4 * kDraws);
    const double white = options.accel_noise_mps2 / std::sqrt(200);
    EXPECT_NEAR(std::log2(with.imu->accel_noise / white), 0, 0.8) << draw;
    EXPECT_NEAR(std::log2(with.imu->gyro_noise / (0.01 / std::sqrt(200))), 0, 0.5) << draw;
  }
  EXPECT_GT(pose, 0.6);
  EXPECT_LT(pose, 1.5);
  EXPECT_GT(twist, 0.6);
  EXPECT_LT(twist, 1.5);
  EXPECT_LT(calibration, 3);
}

// One that stands away from the body's origin, with other axes: the same flight by another body.
// What is told of it may be off, and is found.
TEST(ImuInBatch, SlowFindsWhereItStandsInTheBody) {
  ImuFlightOptions options;
  options.duration_s = 6;
  options.seed = 5;
  options.gap_period_s = 3;
  options.gap_s = 1;
  ImuFlight flight = SimulateWithImu("agile", options);
  const Pose body_from_imu = MakePose(ExpSo3({2, -0.5, 0.7}), {0.15, -0.1, 0.2});
  tagtwist::SetUp set_up = CourseSetUp();
  RigCamera& camera = set_up.rig.front();
  camera.cam_from_body = camera.cam_from_body * Inverse(body_from_imu);
  for (BodyState& state : flight.truth) {
    const Pose world_from_imu = state.world_from_body;
    const Eigen::Vector3d rate = body_from_imu.rotation() * state.twist.omega_body;
    state.world_from_body = world_from_imu * Inverse(body_from_imu);
    state.twist.v_world -=
        state.world_from_body.rotation() * rate.cross(body_from_imu.translation());
    state.twist.omega_body = rate;
  }
  ImuOptions imu;
  const Eigen::Vector3d off(0.012, -0.008, 0.01), turn(0.01, -0.015, 0.02);
  imu.body_from_imu =
      MakePose(body_from_imu.rotation() * ExpSo3(-turn), body_from_imu.translation() - off);
  const Estimate with = Solve(flight, &imu, set_up);
  ASSERT_TRUE(with.imu) << with.warnings.back();
  for (const bool with_tags : {true, false}) {
    const ImuFlightErrors errors = ErrorsOf(with.frames, flight, with_tags);
    EXPECT_LT(errors.largest_m, 0.04);
    EXPECT_GT(errors.nees_pose, 0.4) << with_tags;
    EXPECT_LT(errors.nees_pose, 2) << with_tags;
    EXPECT_GT(errors.nees_twist, 0.4) << with_tags;
    EXPECT_LT(errors.nees_twist, 2) << with_tags;
  }
  const Eigen::Vector3d place = with.imu->imu_in_body_m - body_from_imu.translation();
  EXPECT_LT(place.cwiseQuotient(with.imu->imu_in_body_sigma_m).norm(), 5);
  EXPECT_LT(place.norm(), 0.006);
  EXPECT_LT(with.imu->imu_in_body_sigma_m.maxCoeff(), 0.005);
  EXPECT_LT((with.imu->mount_rad - turn).cwiseQuotient(with.imu->mount_sigma_rad).norm(), 4);
  EXPECT_LT(with.imu->mount_sigma_rad.maxCoeff(), 0.005);
}

// Where no tag is seen it carries the state, far nearer than the motion prior does.
TEST(ImuInBatch, SlowCarriesTheStateThroughGaps) {
  constexpr int kDraws = 3;
  double nees_pose = 0, nees_twist = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    ImuFlightOptions options;
    options.gap_period_s = 4;
    options.gap_s = 1.5;
    options.duration_s = 8;
    options.seed = 1 + static_cast<uint64_t>(draw);
    const ImuFlight flight = SimulateWithImu("agile", options);
    const ImuOptions imu;
    const ImuFlightErrors with = ErrorsOf(Solve(flight, &imu).frames, flight, false);
    EXPECT_GT(with.n, 60);
    EXPECT_LT(with.largest_m, 0.04);
    nees_pose += with.nees_pose / kDraws;
    nees_twist += with.nees_twist / kDraws;
    if (draw > 0) continue;
    const ImuFlightErrors without = ErrorsOf(Solve(flight, nullptr).frames, flight, false);
    EXPECT_LT(with.position_m, 0.1 * without.position_m);
  }
  EXPECT_GT(nees_pose, 0.3);
  EXPECT_LT(nees_pose, 2);
  EXPECT_LT(nees_twist, 2);
}

// What is not so is told, and the estimate is that of the tags.
TEST(ImuInBatch, IsLeftOutWhereItDoesNotFit) {
  ImuFlightOptions options;
  options.duration_s = 4;
  const ImuFlight flight = SimulateWithImu("agile", options);
  const Estimate plain = Solve(flight, nullptr);
  const auto expect_left_out = [&](const ImuFlight& wrong, const char* why) {
    const ImuOptions imu;
    const Estimate out = Solve(wrong, &imu);
    EXPECT_FALSE(out.imu);
    EXPECT_THAT(out.warnings, ::testing::Contains(HasSubstr(why)));
    ASSERT_EQ(out.frames.size(), plain.frames.size());
    EXPECT_LT(Difference(out.frames[50].state, plain.frames[50].state).norm(), 1e-9);
  };
  ImuFlight wrong = flight;
  for (ImuSample& sample : wrong.imu) {
    const Eigen::Quaterniond turned = ExpSo3({0, 0, M_PI / 2});
    sample.gyro_radps = turned * sample.gyro_radps;
    sample.accel_mps2 = turned * sample.accel_mps2;
  }
  expect_left_out(wrong, "axes are not the body's");
  wrong = flight;
  for (ImuSample& sample : wrong.imu) sample.accel_mps2 /= 9.81;  // in g
  expect_left_out(wrong, "gravity 9.81");
  wrong = flight;
  wrong.imu.resize(40);
  expect_left_out(wrong, "covers");
}

// A clock that is far off is found first.
TEST(ImuInBatch, SlowFindsAClockThatIsFarOff) {
  ImuFlightOptions options;
  options.clock_s = 0.12;
  options.duration_s = 4;
  const ImuFlight flight = SimulateWithImu("agile", options);
  const ImuOptions imu;
  const Estimate with = Solve(flight, &imu);
  ASSERT_TRUE(with.imu);
  EXPECT_NEAR(with.imu->time_offset_s, 0.12, 5e-4);
}

}  // namespace
}  // namespace tagtwist::internal::imu_batch_test
