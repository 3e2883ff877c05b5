#include "frontend/base/statistics/student_t.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tagtwist::internal::student_t_test {
namespace {

// Tables of Student's t (Fisher and Yates), two-sided.
TEST(StudentT, AgreesWithTheTables) {
  EXPECT_NEAR(StudentBand(0.95, 1), 12.7062047, 1e-6);
  EXPECT_NEAR(StudentBand(0.95, 10), 2.22813885, 1e-7);
  EXPECT_NEAR(StudentBand(0.99, 4), 4.60409487, 1e-7);
  EXPECT_NEAR(StudentBand(0.99, 23), 2.80733568, 1e-7);
  EXPECT_NEAR(StudentBand(0.95, 1e7), 1.95996422, 1e-5);
}

// One degree of freedom is Cauchy's distribution; two have a closed form, too.
TEST(StudentT, AgreesWithClosedForms) {
  for (const double t : {0.01, 0.5, 1.0, 3.0, 40.0, 1e4}) {
    EXPECT_NEAR(StudentTwoSided(t, 1) / (2 / M_PI * std::atan2(1, t)), 1, 1e-9) << t;
    const double of_two = 2 / (std::sqrt(2 + t * t) * (std::sqrt(2 + t * t) + t));
    EXPECT_NEAR(StudentTwoSided(t, 2) / of_two, 1, 1e-9) << t;
    EXPECT_EQ(StudentTwoSided(t, 7), StudentTwoSided(-t, 7));
  }
  EXPECT_EQ(StudentTwoSided(0, 5), 1);
}

TEST(RegularisedBeta, IsSymmetricAndEndsAtOne) {
  EXPECT_EQ(RegularisedBeta(0, 2, 3), 0);
  EXPECT_EQ(RegularisedBeta(1, 2, 3), 1);
  for (const double x : {0.1, 0.4, 0.9}) {
    EXPECT_NEAR(RegularisedBeta(x, 2.5, 0.5) + RegularisedBeta(1 - x, 0.5, 2.5), 1, 1e-12);
    EXPECT_NEAR(RegularisedBeta(x, 3, 1), x * x * x, 1e-12);
  }
}

}  // namespace
}  // namespace tagtwist::internal::student_t_test
