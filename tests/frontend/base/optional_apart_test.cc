#include "frontend/types/optional_apart.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <optional>
#include <utility>

#include "frontend/types/measurements.h"

namespace tagtwist::internal::optional_apart_test {
namespace {

using Matrix8 = Eigen::Matrix<double, 8, 8>;

TEST(OptionalApart, CopiesAreDeep) {
  OptionalApart<Matrix8> a = Matrix8::Identity();
  OptionalApart<Matrix8> b = a;
  (*b)(0, 0) = 2;
  EXPECT_EQ((*a)(0, 0), 1);
  EXPECT_FALSE(a == b);
  a = b;
  EXPECT_TRUE(a == b);
  const OptionalApart<Matrix8>& same = a;
  a = same;
  EXPECT_TRUE(a == b) << "of itself";
  a = OptionalApart<Matrix8>();
  EXPECT_FALSE(a);
  EXPECT_FALSE(a == b);
  EXPECT_EQ((*b)(0, 0), 2);
}

TEST(OptionalApart, TakesWhatAnOptionalTakes) {
  OptionalApart<Matrix8> a;
  EXPECT_FALSE(a.has_value());
  EXPECT_EQ(a.value_or(Matrix8::Identity()), Matrix8::Identity());
  a = 3 * Matrix8::Identity();
  EXPECT_EQ(a->trace(), 24);
  EXPECT_EQ(a.value_or(Matrix8::Zero()), *a);
  OptionalApart<Matrix8> moved = std::move(a);
  EXPECT_EQ(moved->trace(), 24);
  moved = std::nullopt;
  EXPECT_FALSE(moved);
  moved.emplace(Matrix8::Ones());
  EXPECT_EQ((*moved)(7, 0), 1);
  moved.reset();
  EXPECT_FALSE(moved);
}

// A recording's corners are kept twice while it is solved, and those of a file have no covariance.
TEST(OptionalApart, ATagWithoutACovarianceIsLittleMoreThanItsCorners) {
  EXPECT_LE(sizeof(TagDetection), sizeof(std::array<Eigen::Vector2d, 4>) + 32);
}

}  // namespace
}  // namespace tagtwist::internal::optional_apart_test
