#include "frontend/base/ratio_statistic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace tagtwist::internal::ratio_statistic_test {
namespace {

// Blocks of unequal size whose values have a common part: plain standard deviations would be too
// small.
RatioStatistic Draw(unsigned seed, size_t blocks, double mean) {
  std::mt19937_64 rng(seed);
  std::normal_distribution<double> normal;
  RatioStatistic out;
  for (size_t b = 0; b < blocks; ++b) {
    const double common = mean + normal(rng);
    const size_t n = 5 + rng() % 20;
    for (size_t i = 0; i < n; ++i) out.Add(common + 0.5 * normal(rng));
    out.CloseBlock();
  }
  return out;
}

TEST(RatioStatistic, StandardDeviationIsThatOfTheRatioOverDraws) {
  std::vector<double> ratios;
  double variance = 0;
  constexpr unsigned kDraws = 2000;
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    const RatioStatistic s = Draw(seed, 30, 0);
    ratios.push_back(s.ratio());
    variance += s.variance() / kDraws;
  }
  double squares = 0;
  for (const double r : ratios) squares += r * r / kDraws;
  EXPECT_NEAR(variance / squares, 1, 0.1);
}

// Few blocks, where Student's t has heavy tails: a normal deviate of 2 is passed in 4.55 % of
// draws.
TEST(RatioStatistic, ScoresAreNormalDeviatesForFewBlocksToo) {
  constexpr unsigned kDraws = 20000;
  int beyond = 0;
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    std::mt19937_64 rng(seed);
    std::normal_distribution<double> normal;
    RatioStatistic s;
    for (int b = 0; b < 6; ++b) {
      s.Add(3 + normal(rng));
      s.CloseBlock();
    }
    if (std::abs(s.Score(3)) > 2) ++beyond;
  }
  EXPECT_NEAR(static_cast<double>(beyond) / kDraws, 0.0455, 0.006);
}

TEST(RatioStatistic, FewBlocksSayNothing) {
  EXPECT_EQ(Draw(1, RatioStatistic::kLeastBlocks - 1, 100).Score(0), 0);
  EXPECT_GT(Draw(1, RatioStatistic::kLeastBlocks, 100).Score(0), 3);
  RatioStatistic none;
  none.CloseBlock();
  EXPECT_EQ(none.blocks(), 0u);
  EXPECT_EQ(none.Score(1), 0);
}

TEST(RatioStatistic, DifferenceIsScoredWithBothVariances) {
  const RatioStatistic a = Draw(1, 200, 1), b = Draw(2, 200, 0);
  EXPECT_GT(ScoreOfDifference(a, b), 7);
  EXPECT_LT(ScoreOfDifference(a, b), 13);
  EXPECT_LT(ScoreOfDifference(b, a), -7);
}

TEST(RatioStatistic, SignificanceGrowsWithTheTests) {
  EXPECT_NEAR(SignificantScore(1), 3.2905, 1e-3);
  EXPECT_NEAR(SignificantScore(100), 4.4172, 1e-3);
}

}  // namespace
}  // namespace tagtwist::internal::ratio_statistic_test
