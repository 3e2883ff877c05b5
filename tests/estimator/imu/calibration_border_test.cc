#include "estimator/window/imu/calibration_border.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "estimator/imu/imu_solve.h"
#include "estimator/solve/noise_learning.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/imu_flight.h"

namespace tagtwist::internal::calibration_border_test {
namespace {

// A chain of a flight's frames with an IMU, the first one known together with its calibration.
struct Chained {
  QuadraticChain chain;
  CalibrationBorder border;
  std::vector<GraphFrame> frames;
  BlockBandedMatrix covariance{0, 0};

  void Solve() {
    auto solved = chain.Solve({8, 1e-9}, {1e-6, true});
    ASSERT_TRUE(solved) << solved.error().message;
    covariance = std::move(solved->covariance);
    TakeStates(chain.graph(), &frames);
    ASSERT_TRUE(border.Update(&chain, &covariance, &frames));
  }
};

Chained MakeChained(int n) {
  ImuFlightOptions options;
  options.duration_s = 2;
  options.clock_s = 0.002;
  const ImuFlight flight = SimulateWithImu("agile", options);
  const EstimatorSetup setup = CourseSetup();
  ImuModel model;
  CalibratedState known;
  known.covariance.diagonal() << 1e-4, 1e-4, 1e-5, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4;
  known.given_calibration = 1e-3 * Block::Identity();
  known.by_calibration.setConstant(0.002);
  Chained out;
  const std::vector<ImuSample> samples = InBody(flight.imu, model.calibration);
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<size_t>(10 + i);
    GraphFrame frame;
    frame.t_ns = flight.measurements[k].t_ns;
    frame.state = flight.truth[k];
    frame.tags = flight.measurements[k].tags;
    SetImuFactors(samples, {}, model, out.frames.empty() ? nullptr : &out.frames.back(), &frame);
    out.frames.push_back(std::move(frame));
  }
  GraphInput input;
  input.frames = out.frames;
  NoiseModel noise = InitialNoise({});
  noise.corner_sigma_px = 0.3;
  out.chain = QuadraticChain(BuildWholeGraph(setup, WithImu(noise), input), InOneRange,
                             CalibrationBorder::kTangent);
  out.chain.SetPrior(known.given_calibration.inverse());
  out.border = CalibrationBorder(known, out.chain.graph().states.front());
  return out;
}

// What has left is not forgotten: the states that stay and the calibration are known as well, and
// the same, as with it.
TEST(CalibrationBorder, WhatLeavesStaysKnown) {
  Chained whole = MakeChained(8);
  for (int i = 0; i < 4; ++i) whole.Solve();  // to its end
  Chained rest = whole;
  for (int i = 0; i < 3; ++i) {
    rest.border.MarginalizeFirst(rest.chain);
    rest.chain.MarginalizeFirst();
    rest.frames.erase(rest.frames.begin());
  }
  whole.Solve();
  rest.Solve();
  for (int k = 0; k < 5; ++k) {
    const Block of_rest = rest.covariance.At(k, k), of_whole = whole.covariance.At(k + 3, k + 3);
    const Block scaled = of_whole.llt().matrixL().solve(of_rest - of_whole);
    // At the edge rates change as of one side alone.
    EXPECT_LT((of_rest - of_whole).norm(), 0.05 * of_whole.norm()) << k;
    EXPECT_LT(scaled.cwiseAbs().maxCoeff(), 0.05) << k;
    const auto i = static_cast<size_t>(k);
    EXPECT_LT(Difference(rest.frames[i].state, whole.frames[i + 3].state).head<6>().norm(), 1e-4)
        << k;
  }
  const ImuStepCovariance a = rest.border.covariance(), b = whole.border.covariance();
  for (int i = 0; i < kImuEntries; ++i) EXPECT_NEAR(a(i, i) / b(i, i), 1, 0.05) << i;
  EXPECT_NEAR(rest.border.calibration().time_offset_s, whole.border.calibration().time_offset_s,
              1e-5);
}

// Its sigmas fall with what is measured, and states without it would be told too sure.
TEST(CalibrationBorder, IsInTheStatesCovariance) {
  Chained chained = MakeChained(8);
  auto solved = chained.chain.Solve({8, 1e-9}, {1e-6, true});
  ASSERT_TRUE(solved);
  const Block given = solved->covariance.At(7, 7);
  const ImuStepCovariance before = chained.border.covariance();
  chained.Solve();
  const Block open = chained.covariance.At(7, 7) - given;
  EXPECT_GT(open.trace(), 0);
  const Block symmetric = 0.5 * (open + open.transpose());
  const Eigen::SelfAdjointEigenSolver<Block> own(symmetric);
  EXPECT_GT(own.eigenvalues().minCoeff(), -1e-6 * open.trace());
  const ImuStepCovariance after = chained.border.covariance();
  for (int i = 0; i < kImuEntries; ++i) EXPECT_LT(after(i, i), before(i, i) * (1 + 1e-9)) << i;
}

}  // namespace
}  // namespace tagtwist::internal::calibration_border_test
