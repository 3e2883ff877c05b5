#include "estimator/motion/open_intervals.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "estimator/motion/bank/motion_bank.h"
#include "estimator/motion/open_motion_of_chain.h"
#include "residuals/motion_residual.h"

namespace tagtwist::internal::open_intervals_test {
namespace {

constexpr int kStates = 8, kJump = 3,
              kDecades = 10;  // the jump is in the interval after that state
constexpr double kDtS = 0.05, kSigmaM = 2e-3, kSigmaRad = 1e-3;

// Positions of a body that is at rest, then has a speed at once, as measured.
std::vector<Eigen::Vector3d> Measured(double jump_mps) {
  std::mt19937 rng(3);
  std::normal_distribution<double> normal(0, kSigmaM);
  std::vector<Eigen::Vector3d> out;
  for (int k = 0; k < kStates; ++k) {
    const double moved = jump_mps * kDtS * std::max(k - kJump - 0.4, 0.0);
    out.push_back(Eigen::Vector3d(moved, 0, 0) +
                  Eigen::Vector3d::NullaryExpr([&](Eigen::Index) { return normal(rng); }));
  }
  return out;
}

// All states at once, which are linear for a body that does not turn.
struct Solved {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;
  double log_likelihood = 0;  // but for a constant
};

// With the density of the linear motion `times` as high in that interval.
Solved Solve(const std::vector<Eigen::Vector3d>& measured, const NoiseModel& noise, int interval,
             double times) {
  // On acceleration three of an interval's nine rows are idle.
  const int n = kBlockSize * kStates, rows = noise.linear.on == WhiteNoiseOn::kJerk ? 9 : 6;
  const GraphState zero;
  const std::array<const double*, 4> at = {zero.pose.params.data(), zero.rates.data(),
                                           zero.pose.params.data(), zero.rates.data()};
  Eigen::Matrix<double, 18, 1> residual;
  Eigen::Matrix<double, 18, 36> jacobian;
  MotionResidual(kDtS, noise.linear, noise.angular).Linearize(at.data(), &residual, &jacobian);
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  h.topLeftCorner<18, 18>().diagonal().array() += 1e-2;
  double squares = 0;
  for (int k = 0; k < kStates; ++k) {
    const int i = kBlockSize * k;
    h.diagonal().segment<3>(i).array() += 1 / (kSigmaRad * kSigmaRad);
    h.diagonal().segment<3>(i + 3).array() += 1 / (kSigmaM * kSigmaM);
    b.segment<3>(i + 3) += measured[static_cast<size_t>(k)] / (kSigmaM * kSigmaM);
    squares += measured[static_cast<size_t>(k)].squaredNorm() / (kSigmaM * kSigmaM);
    if (k + 1 == kStates) continue;
    Eigen::Matrix<double, 18, 36> j = jacobian;
    if (k == interval) j.middleRows(9, rows) /= std::sqrt(times);
    h.block<36, 36>(i, i) += j.transpose() * j;
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(h);
  Solved out;
  out.x = llt.solve(b);
  out.covariance = llt.solve(Eigen::MatrixXd::Identity(n, n));
  out.log_likelihood = -0.5 * (squares - b.dot(out.x)) - 0.5 * rows * std::log(times) -
                       llt.matrixLLT().diagonal().array().log().sum();
  return out;
}

struct Chain {
  std::vector<GraphState> states;
  BlockBandedMatrix covariance{kStates, 1};
};

Chain ChainOf(const Solved& solved) {
  Chain out;
  for (int k = 0; k < kStates; ++k) {
    GraphState state;
    state.t_ns = std::llround(k * kDtS * 1e9);
    out.states.push_back(Retract(state, solved.x.segment<18>(kBlockSize * k)));
    for (int l = std::max(k - 1, 0); l <= k; ++l) {
      out.covariance.At(k, l) = solved.covariance.block<18, 18>(kBlockSize * k, kBlockSize * l);
    }
  }
  return out;
}

NoiseModel Noise(WhiteNoiseOn on) {
  const double psd = on == WhiteNoiseOn::kJerk ? 100 : 0.01;
  NoiseModel out;
  out.linear = {on, psd};
  out.angular = {on, psd};
  return out;
}

class OpenMotions : public testing::TestWithParam<WhiteNoiseOn> {
 protected:
  // What states that are smooth else cannot hide.
  static double JumpMps() { return GetParam() == WhiteNoiseOn::kJerk ? 3.0 : 0.3; }
};

// By solving anew with each density: the sum over all is what the interval is told to leave open.
TEST_P(OpenMotions, IsTheMixtureOfTheLivelierSolutions) {
  const NoiseModel noise = Noise(GetParam());
  const auto measured = Measured(JumpMps());
  const Solved solved = Solve(measured, noise, -1, 1);
  const Chain chain = ChainOf(solved);
  const MotionBankOptions bank;
  const double prior = -std::expm1(-kDtS / bank.switch_s) / bank.classes;
  const SolvedChain of_chain{chain.states, chain.covariance, noise};
  for (const int interval : {kJump, kJump + 1}) {
    double sum = 0;
    std::vector<StateCovariance> spreads(kStates, StateCovariance::Zero());
    for (int i = 1; i <= kDecades; ++i) {
      const Solved other = Solve(measured, noise, interval, std::pow(10.0, i));
      const double weight = prior * std::exp(other.log_likelihood - solved.log_likelihood);
      for (int k = 0; k < kStates; ++k) {
        const auto d = (other.x - solved.x).segment<12>(kBlockSize * k).eval();
        spreads[static_cast<size_t>(k)] +=
            weight *
            ((other.covariance - solved.covariance).block<12, 12>(kBlockSize * k, kBlockSize * k) +
             d * d.transpose());
      }
      sum += weight;
    }
    const OpenInterval open = OpenAfter(interval, of_chain, {true, true}).linear;
    EXPECT_NEAR(open.log_weight, std::log(sum), 0.05);
    ASSERT_GE(open.spreads.size(), 4U);
    for (size_t i = 0; i < open.spreads.size(); ++i) {
      const StateCovariance expected = spreads[static_cast<size_t>(open.first_state) + i] / sum;
      EXPECT_LT((open.spreads[i] - expected).norm(), 0.05 * expected.norm()) << interval;
    }
  }
}

TEST_P(OpenMotions, WhatIsLeftOpenCoversAJumpAndNothingElse) {
  const NoiseModel noise = Noise(GetParam());
  for (const double jump_mps : {0.0, JumpMps()}) {
    const Solved solved = Solve(Measured(jump_mps), noise, -1, 1);
    const Chain chain = ChainOf(solved);
    std::vector<StateCovariance> covariances(kStates, StateCovariance::Zero());
    AddOpenMotion({chain.states, chain.covariance, noise}, {true, true}, InOneRange, &covariances);
    for (int k = kJump - 1; k < kJump + 3; ++k) {
      const double open = covariances[static_cast<size_t>(k)](6, 6),
                   known = solved.covariance(kBlockSize * k + 6, kBlockSize * k + 6),
                   off = solved.x(kBlockSize * k + 6) - (k > kJump ? jump_mps : 0);
      if (jump_mps > 0) {
        EXPECT_LT(off * off, 9 * (known + open)) << k;
      } else {
        EXPECT_LT(open, 0.3 * known) << k;
      }
    }
    if (jump_mps > 0) {
      const int k = kJump + 1;
      const double off = solved.x(kBlockSize * k + 6) - jump_mps;
      EXPECT_GT(off * off, 25 * solved.covariance(kBlockSize * k + 6, kBlockSize * k + 6));
    }
  }
}

// A window's states get what all of the chain's would, though each interval is looked at once.
TEST_P(OpenMotions, AWindowRemembersWhatLeft) {
  const NoiseModel noise = Noise(GetParam());
  const Chain chain = ChainOf(Solve(Measured(JumpMps()), noise, -1, 1));
  const SolvedChain of_chain{chain.states, chain.covariance, noise};
  OpenIntervals all;
  for (int k = 0; k + 1 < kStates; ++k) all.Add(OpenAfter(k, of_chain, {true, true}));
  OpenMotionOfWindow window;
  for (int oldest = 0; oldest < kStates; ++oldest) {
    window.Look(of_chain, oldest, {true, true}, oldest + 3 > kStates);
    EXPECT_EQ(window.Of(0), all.Of(oldest)) << oldest;
    window.Forget(1);
  }
  window.Look(of_chain, 0, {true, true}, true);
  window.Forget(kStates);
  EXPECT_EQ(window.Of(0).norm(), 0) << "all have left";
}

// Of the last state as of any other, but for its own interval.
TEST_P(OpenMotions, TheLastStateHasWhatTheIntervalsBeforeItsOwnLeaveOpen) {
  const NoiseModel noise = Noise(GetParam());
  const Chain whole = ChainOf(Solve(Measured(JumpMps()), noise, -1, 1));
  const SolvedChain of_chain{whole.states, whole.covariance, noise};
  OpenIntervals near;
  for (const int k : {kStates - 4, kStates - 3}) near.Add(OpenAfter(k, of_chain, {true, true}));
  const StateCovariance expected = near.Of(kStates - 1);
  EXPECT_GT(expected.norm(), 0);
  EXPECT_TRUE(OpenBeforeTheLast(of_chain, {true, true}).isApprox(expected, 1e-12));
}

// Ranges that are done at the same time need nothing of one another.
TEST_P(OpenMotions, RangesDoNotShow) {
  const NoiseModel noise = Noise(GetParam());
  const Chain chain = ChainOf(Solve(Measured(JumpMps()), noise, -1, 1));
  const SolvedChain of_chain{chain.states, chain.covariance, noise};
  std::vector<StateCovariance> one(kStates, StateCovariance::Zero()), many = one;
  AddOpenMotion(of_chain, {true, true}, InOneRange, &one);
  AddOpenMotion(
      of_chain, {true, true},
      [](size_t count, const std::function<void(size_t, size_t)>& work) {
        for (size_t i = 0; i < count; ++i) work(i, i + 1);
      },
      &many);
  EXPECT_EQ(one, many);
}

INSTANTIATE_TEST_SUITE_P(Both, OpenMotions,
                         testing::Values(WhiteNoiseOn::kJerk, WhiteNoiseOn::kAcceleration));

}  // namespace
}  // namespace tagtwist::internal::open_intervals_test
