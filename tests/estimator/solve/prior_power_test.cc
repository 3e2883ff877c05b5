#include "estimator/solve/prior_power.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "estimator/batch/batch.h"
#include "estimator/graph/linear_system.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/smoother.h"
#include "estimator/start/recording_start.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/simulated_flight.h"
#include "tests/support/flights/window_run.h"

namespace tagtwist::internal::prior_power_test {
namespace {

Solution Solved(const ExactModelOptions& model, const std::vector<FrameMeasurements>& frames) {
  const EstimatorSetup setup = CourseSetup(GivenNoise(model));
  GraphInput input;
  input.frames = *StartFrames(setup, frames);
  return *SolveAndInvert(setup, InitialNoise(setup.options), input, {50});
}

class PriorPowerTest : public UnderBothPriors {};
INSTANTIATE_UNDER_BOTH_PRIORS(PriorPowerTest);

TEST_P(PriorPowerTest, WhereThePriorHoldsThePowerIsOneOnAverage) {
  double sum = 0;
  constexpr int kFlights = 30;
  for (unsigned seed = 1; seed <= kFlights; ++seed) {
    const ExactModelFlight flight = DrawFlight(Model(seed));
    sum += FindPriorPower(Solved(Model(seed), flight.measurements).graph).statistic.RawPower();
  }
  EXPECT_NEAR(sum / kFlights, 1.0, 0.4);
}

TEST_P(PriorPowerTest, TheSharesOfPriorAndMeasurementsAreThoseOfTheDenseInverse) {
  ExactModelOptions model = Model(3);
  model.frames = 12;
  const ExactModelFlight flight = DrawFlight(model);
  const Solution solution = Solved(model, flight.measurements);
  const int size = 12 * BlockBandedMatrix::kSize;
  const auto dense = [&](const LinearSystem& system) {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size, size);
    constexpr int kSize = BlockBandedMatrix::kSize;
    for (int j = 0; j < 12; ++j) {
      for (int i = j; i < std::min(12, j + 2); ++i) {
        out.block<kSize, kSize>(kSize * i, kSize * j) = system.hessian.At(i, j);
        out.block<kSize, kSize>(kSize * j, kSize * i) = system.hessian.At(i, j).transpose();
      }
    }
    return out;
  };
  std::vector<bool> motion;
  for (const Factor& f : solution.graph.factors) motion.push_back(f.kind == FactorKind::kMotion);
  const Eigen::MatrixXd p = dense(Linearize(solution.graph)).inverse();
  const Eigen::MatrixXd of_prior = p * dense(Linearize(solution.graph, motion)) * p;
  const PriorPower prior = FindPriorPower(solution.graph);
  for (int k = 0; k < 12; ++k) {
    const auto expected = of_prior.block<12, 12>(18 * k, 18 * k);
    // Relative to the covariance: the numeric derivative is exact to a few percent of it.
    const StateCovariance root = StateCovariance(p.block<12, 12>(18 * k, 18 * k)).llt().matrixL();
    const StateCovariance relative = root.inverse() *
                                     (prior.of_prior[static_cast<size_t>(k)] - expected) *
                                     root.inverse().transpose();
    EXPECT_LT(relative.cwiseAbs().maxCoeff(), 0.03) << k;
  }
}

struct NeesPerDof {
  double pose = 0, twist = 0;
};
NeesPerDof MeanNees(const std::vector<FrameEstimate>& frames, const std::vector<BodyState>& truth) {
  NeesPerDof out;
  for (size_t i = 0; i < frames.size(); ++i) {
    const StateVector e = Difference(frames[i].state, truth[i]);
    const StateCovariance& c = frames[i].covariance;
    const double scale = 1.0 / (6.0 * static_cast<double>(frames.size()));
    out.pose += scale * e.head<6>().dot(c.topLeftCorner<6, 6>().llt().solve(e.head<6>()));
    out.twist += scale * e.tail<6>().dot(c.bottomRightCorner<6, 6>().llt().solve(e.tail<6>()));
  }
  return out;
}

// A sum of sines has nothing at the limit of resolution: without the calibration the twist's
// covariance is twice too large.
TEST(PriorPower, SlowOnASmoothFlightTheTwistsCovarianceHolds) {
  const SimulatedFlight flight = SimulateCorners("agile", 12);
  const auto result = RunBatch(CourseSetUp(), {}, flight.measurements);
  ASSERT_TRUE(result) << result.error().message;
  const NeesPerDof calibrated = MeanNees(result->frames, flight.truth);
  EXPECT_GT(calibrated.twist, 0.7);
  EXPECT_LT(calibrated.twist, 1.4);
  EXPECT_GT(calibrated.pose, 0.8);
  EXPECT_LT(calibrated.pose, 1.3);
  std::vector<FrameEstimate> plain = result->frames;
  for (size_t i = 0; i < plain.size(); ++i) {
    plain[i].covariance = result->trajectory.covariances[i].topLeftCorner<12, 12>();
  }
  EXPECT_LT(MeanNees(plain, flight.truth).twist, 0.65);
}

TEST(PriorPower, SlowTheFramesThatLeaveAWindowHaveItsPowerToo) {
  const SimulatedFlight flight = SimulateCorners("agile", 12);
  std::vector<FrameEstimate> lagged = RunWindow(CourseSetup(), flight.measurements).lagged;
  constexpr size_t kKnown = 150;  // the frames that the first calibration came of, and more
  const std::vector<BodyState> truth(flight.truth.begin() + kKnown,
                                     flight.truth.begin() + lagged.size());
  lagged.erase(lagged.begin(), lagged.begin() + kKnown);
  const NeesPerDof nees = MeanNees(lagged, truth);
  EXPECT_GT(nees.twist, 0.7);
  EXPECT_LT(nees.twist, 1.4);
  EXPECT_GT(nees.pose, 0.7);
  EXPECT_LT(nees.pose, 1.4);
}

// What is gathered from pieces of a graph is what the whole says, and so is what one step at a time
// gives: for the window takes that, the batch the pieces.
TEST(PriorPower, PiecesSayWhatTheWholeSays) {
  ExactModelOptions model;
  model.frames = 40;
  const Solution solution = Solved(model, DrawFlight(model).measurements);
  PriorPowerFinder finder(solution.graph);
  while (!finder.done()) finder.Step();
  const PriorPower& whole = finder.result();
  for (const int length : {1, 7, 13, 39, 64}) {
    const PriorPower prior = FindPriorPower(solution.graph, length);
    EXPECT_NEAR(prior.statistic.found, whole.statistic.found, 1e-7 * whole.statistic.found);
    EXPECT_NEAR(prior.statistic.noise_alone, whole.statistic.noise_alone, 1e-7);
    EXPECT_NEAR(prior.statistic.under_prior, whole.statistic.under_prior, 1e-7);
    ASSERT_EQ(prior.covariances.size(), whole.covariances.size());
    for (size_t k = 0; k < whole.covariances.size(); ++k) {
      EXPECT_TRUE(prior.covariances[k].isApprox(whole.covariances[k], 1e-9)) << length << " " << k;
      EXPECT_TRUE(prior.of_prior[k].isApprox(whole.of_prior[k], 1e-7)) << length << " " << k;
    }
  }
}

// States that hang on the prior alone are not promised anything that only holds elsewhere.
// Of states microseconds apart the differences that it is made of are rounding's.
TEST(PriorPower, WhatRoundingMadeOfItDoesNotCount) {
  EXPECT_EQ((PowerStatistic{0.104, -2.6, -1.06}).Power(), 1);
  EXPECT_GT((PowerStatistic{20, -0.2, 5}).Power(), 1.5);
  PriorPower prior;
  for (const double of_prior : {-0.9, 0.5}) {
    prior.covariances.emplace_back(StateCovariance::Identity());
    prior.of_prior.emplace_back(of_prior * StateCovariance::Identity());
  }
  const auto scaled = WithPriorPower(5, prior);
  EXPECT_EQ(scaled[0], StateCovariance::Identity());
  EXPECT_DOUBLE_EQ(scaled[1](0, 0), 3);
}

TEST(PriorPower, AGapKeepsItsCovariance) {
  ExactModelOptions model;
  const ExactModelFlight flight = DrawFlight(model);
  std::vector<FrameMeasurements> blind = flight.measurements;
  for (size_t i = 20; i < 45; ++i) blind[i].tags.clear();
  const Solution solution = Solved(model, blind);
  const PriorPower prior = FindPriorPower(solution.graph);
  const auto covariances = WithPriorPower(0.05, prior);
  const auto twist_ratio = [&](size_t i) {
    const auto k = static_cast<int>(i);
    return covariances[i].bottomRightCorner<6, 6>().trace() /
           BodyCovariance(solution.covariance, k).bottomRightCorner<6, 6>().trace();
  };
  EXPECT_GT(twist_ratio(32), 0.9);
  EXPECT_LT(twist_ratio(10), 0.7);
}

}  // namespace
}  // namespace tagtwist::internal::prior_power_test
