#include "frontend/base/statistics/chi_square.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tagtwist::internal::chi_square_test {
namespace {

struct Case {
  double probability, dof, quantile;
};

TEST(ChiSquare, QuantilesMatchPublishedTables) {
  for (const Case& c :
       {Case{0.95, 1, 3.841459}, Case{0.99, 1, 6.634897}, Case{0.95, 2, 5.991465},
        Case{0.95, 6, 12.591587}, Case{0.025, 6, 1.237344}, Case{0.975, 12, 23.336664},
        Case{0.025, 12, 4.403789}, Case{0.95, 100, 124.342113}, Case{0.025, 1000, 914.257154},
        Case{0.975, 1000, 1089.530940}}) {
    EXPECT_NEAR(ChiSquareQuantile(c.probability, c.dof), c.quantile, 1e-5 * c.quantile) << c.dof;
  }
}

TEST(ChiSquare, QuantileInvertsTheDistribution) {
  for (const double dof : {0.5, 3.0, 12.0, 5000.0, 240000.0}) {
    for (const double p : {0.001, 0.3, 0.5, 0.9, 0.999}) {
      EXPECT_NEAR(RegularisedGammaP(dof / 2, ChiSquareQuantile(p, dof) / 2), p, 1e-6) << dof;
    }
  }
}

TEST(ChiSquare, TwoDegreesOfFreedomIsTheExponential) {
  for (const double x : {0.01, 0.5, 2.0, 10.0, 50.0}) {
    EXPECT_NEAR(RegularisedGammaP(1.0, x), 1 - std::exp(-x), 1e-14);
  }
  EXPECT_EQ(RegularisedGammaP(1.0, 0.0), 0.0);
}

TEST(ChiSquare, BandOfTheMeanShrinksAroundTheExpectation) {
  const ChiSquareBand one = MeanChiSquareBand(12, 1), many = MeanChiSquareBand(12, 20000);
  EXPECT_NEAR(one.low, 4.403789, 1e-4);
  EXPECT_NEAR(one.high, 23.336664, 1e-4);
  // Normal approximation: 12 +- 1.959964 sqrt(2 * 12 / 20000).
  EXPECT_NEAR(many.low, 12 - 1.959964 * std::sqrt(24.0 / 20000), 2e-3);
  EXPECT_NEAR(many.high, 12 + 1.959964 * std::sqrt(24.0 / 20000), 2e-3);
}

}  // namespace
}  // namespace tagtwist::internal::chi_square_test
