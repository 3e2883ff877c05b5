// An estimate and its truth are compared where the sparser of the two has its samples.
#include "estimator/evaluation/truth_match.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estimator/evaluation/evaluation.h"
#include "tests/support/evaluation_data.h"

namespace tagtwist::internal::truth_match_test {
namespace {

// Errors drawn from the covariance that the samples state.
PoseSeries HonestSeries(double rate_hz, double sigma) {
  PoseSeries series = SmoothSeries(0, static_cast<size_t>(20 * rate_hz), rate_hz);
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, sigma);
  for (PoseSample& sample : series) {
    StateVector error;
    for (double& value : error) value = normal(random);
    const BodyState state = Retract(BodyState{sample.world_from_body, *sample.twist}, error);
    sample.world_from_body = state.world_from_body;
    sample.twist = state.twist;
    sample.covariance = sigma * sigma * StateCovariance::Identity();
  }
  return series;
}

TEST(TruthMatch, ASparseTruthIsTakenAtItsOwnStamps) {
  const PoseSeries series = SmoothSeries(0, 200, 50);
  for (const double rate_hz : {5.0, 15.0, 30.0}) {
    const auto matches = MatchTruth(series, SmoothTruth(3, rate_hz), 0, 0.1);
    EXPECT_EQ(matches.size(), static_cast<size_t>(3 * rate_hz) + 1);
    for (const TruthMatch& m : matches) EXPECT_EQ(m.estimate.t_ns, m.truth.t_ns);
  }
}

TEST(TruthMatch, ADenseTruthIsAskedAtTheFrames) {
  const PoseSeries series = SmoothSeries(0.003, 100, 50);
  const auto matches = MatchTruth(series, SmoothTruth(3, 200), 0, 0.1);
  ASSERT_EQ(matches.size(), series.size());
  for (size_t i = 0; i < matches.size(); ++i) {
    EXPECT_EQ(matches[i].estimate.t_ns, series[i].t_ns);
  }
}

TEST(TruthMatch, ClocksApartMeet) {
  PoseSeries series = SmoothSeries(0, 200, 50);
  for (PoseSample& sample : series) sample.t_ns -= 2'000'000'000;
  const auto matches = MatchTruth(series, SmoothTruth(3, 15), 2.0, 0.1);
  ASSERT_EQ(matches.size(), 46u);
  for (const TruthMatch& m : matches) {
    EXPECT_LT(
        (m.estimate.world_from_body.translation() - m.truth.world_from_body.translation()).norm(),
        1e-3);
  }
}

// Interpolated, a truth of 15 Hz is off by many times what a good estimate is.
TEST(TruthMatch, ARightEstimateStaysRightByASparseTruth) {
  const PoseSeries series = HonestSeries(50, 1e-4);
  const auto accuracy = Evaluate(series, SmoothTruth(18, 15), {});
  ASSERT_TRUE(accuracy);
  ASSERT_TRUE(accuracy->nees_pose);
  EXPECT_GT(accuracy->nees_pose->per_dof(), 0.3);
  EXPECT_LT(accuracy->nees_pose->per_dof(), 1.5);
}

TEST(TruthMatch, GapsOfTheEstimateAreLeftOut) {
  PoseSeries series = SmoothSeries(0, 200, 50);
  series.erase(series.begin() + 50, series.begin() + 100);  // from 1 to 2 s
  for (const TruthMatch& m : MatchTruth(series, SmoothTruth(3, 15), 0, 0.1)) {
    const double t_s = ToSeconds(m.truth.t_ns);
    EXPECT_TRUE(t_s <= 0.98 || t_s >= 2) << t_s;
  }
}

}  // namespace
}  // namespace tagtwist::internal::truth_match_test
