// Variances of groups of parameters by their evidence, and the field over the image that is one.
#include "estimator/systematic/evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "estimator/systematic/image_field.h"

namespace tagtwist::internal::evidence_test {
namespace {

// y = F x + n with x of two groups of so many parameters and sigmas.
LinearEvidence DrawLinear(double first_sigma, double second_sigma, double noise, int rows,
                          unsigned seed) {
  constexpr int kSize = 30;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Eigen::VectorXd x(2 * kSize), y(rows);
  for (int i = 0; i < x.size(); ++i)
    x(i) = (i < kSize ? first_sigma : second_sigma) * normal(random);
  Eigen::MatrixXd f(rows, 2 * kSize);
  for (double& value : f.reshaped()) value = normal(random);
  for (double& value : y) value = noise * normal(random);
  y += f * x;
  return {f.transpose() * f, f.transpose() * y, y.squaredNorm(), double(rows)};
}

TEST(Evidence, FindsTheVariancesThatParametersWereDrawnFrom) {
  const auto fit = FitByEvidence(DrawLinear(2.0, 0.1, 0.5, 400, 3), {{0, 30, 1}, {30, 30, 1}});
  EXPECT_NEAR(fit.groups[0].sigma, 2.0, 0.6);
  EXPECT_NEAR(fit.groups[1].sigma, 0.1, 0.03);
  EXPECT_NEAR(fit.noise_scale, 0.5, 0.06);
}

TEST(Evidence, FindsNothingInNoise) {
  int found = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto fit = FitByEvidence(DrawLinear(0, 0, 1, 400, seed), {{0, 30, 1}, {30, 30, 1}});
    if (!fit.IsEmpty()) ++found;
  }
  EXPECT_EQ(found, 0);
}

TEST(Evidence, KeepsAGroupThatTheDataDoNotSpeakOfWhereOthersAreSeen) {
  LinearEvidence data = DrawLinear(2.0, 0, 0.5, 400, 5);
  data.information.bottomRows(30).setZero();
  data.information.rightCols(30).setZero();
  data.gradient.tail(30).setZero();
  const auto fit = FitByEvidence(data, {{0, 30, 1}, {30, 30, 0.7}});
  EXPECT_DOUBLE_EQ(fit.groups[1].sigma, 0.7);
  EXPECT_NEAR(fit.root.row(40).squaredNorm(), 0.49, 1e-9);
}

TEST(Evidence, AGivenGroupAloneBringsNothingBack) {
  LinearEvidence data = DrawLinear(2.0, 0, 0.5, 400, 5);
  data.information.bottomRows(30).setZero();
  data.information.rightCols(30).setZero();
  data.gradient.tail(30).setZero();
  const auto fit = FitByEvidence(data, {{0, 30, 2, true}, {30, 30, 0.7}});
  EXPECT_DOUBLE_EQ(fit.groups[0].sigma, 2);
  EXPECT_EQ(fit.groups[1].sigma, 0);
}

TEST(Evidence, LeavesWhatIsGivenAsItIs) {
  const LinearEvidence data = DrawLinear(2.0, 0, 0.5, 400, 5);
  const auto fit = FitByEvidence(data, {{0, 30, 1}, {30, 30, 0.02, true}});
  EXPECT_DOUBLE_EQ(fit.groups[1].sigma, 0.02);
  EXPECT_NEAR(fit.groups[0].sigma, 2.0, 0.6);
}

// A group that chance alone has above its least goes back there, and the search ends.
TEST(Evidence, StaysAtTheLeastWhereNothingIsSeen) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto fit =
        FitByEvidence(DrawLinear(2.0, 0, 0.5, 400, seed), {{0, 30, 1}, {30, 30, 1, false, 1e-4}});
    EXPECT_DOUBLE_EQ(fit.groups[1].sigma, 1e-4) << seed;
    EXPECT_NEAR(fit.groups[0].sigma, 2.0, 0.9) << seed;
  }
}

TEST(Evidence, DoesNotGoBelowTheLeast) {
  const LinearEvidence data = DrawLinear(2.0, 0, 0.5, 400, 5);
  const auto fit = FitByEvidence(data, {{0, 30, 1, false, 0.5}, {30, 30, 1, false, 0.02}});
  EXPECT_NEAR(fit.groups[0].sigma, 2.0, 0.6);
  EXPECT_DOUBLE_EQ(fit.groups[1].sigma, 0.02);
}

TEST(ImageField, IsBilinearBetweenItsKnotsAndConstantBeyondTheImage) {
  const ImageField field(640, 480);
  const auto value = [&](double u, double v, const Eigen::VectorXd& knots) {
    const ImageField::Place place = field.At({u, v});
    double sum = 0, shares = 0;
    for (size_t k = 0; k < 4; ++k) {
      sum += place.shares[k] * knots(place.knots[k]);
      shares += place.shares[k];
    }
    EXPECT_NEAR(shares, 1, 1e-12);
    return sum;
  };
  // A plane over the knots is a plane over the image.
  const int columns = field.At({0, 0}).knots[2] - field.At({0, 0}).knots[0];
  const int rows = field.knots() / columns;
  Eigen::VectorXd plane(field.knots());
  for (int k = 0; k < plane.size(); ++k) {
    plane(k) = (k % columns) / double(columns - 1) + 3 * (k / columns) / double(rows - 1);
  }
  EXPECT_NEAR(value(0, 0, plane), 0, 1e-12);
  EXPECT_NEAR(value(639, 479, plane), 4, 1e-12);
  EXPECT_NEAR(value(213, 100, plane), 213 / 639.0 + 300 / 479.0, 1e-12);
  EXPECT_NEAR(value(-50, 600, plane), 3, 1e-12);
}

TEST(ImageField, VariesByOneEverywhereAPriori) {
  const ImageField field(752, 480);
  const Eigen::VectorXd variances = field.modes().rowwise().squaredNorm();
  EXPECT_GT(variances.minCoeff(), 0.9);
  EXPECT_LT(variances.maxCoeff(), 1.001);
}

}  // namespace
}  // namespace tagtwist::internal::evidence_test
