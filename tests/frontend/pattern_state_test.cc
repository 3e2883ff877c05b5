#include "frontend/pattern/pattern_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "frontend/pattern/pattern_sums.h"
#include "frontend/types/tag_family.h"

namespace tagtwist::internal::pattern_state_test {
namespace {

using Corners = std::array<Eigen::Vector2d, 4>;

Eigen::Matrix<double, 8, 1> Difference(const Corners& a, const Corners& b) {
  Eigen::Matrix<double, 8, 1> out;
  for (int c = 0; c < 4; ++c) {
    out.segment<2>(2 * c) = a[static_cast<size_t>(c)] - b[static_cast<size_t>(c)];
  }
  return out;
}

PatternModel TagFive() { return PatternModel(MakeTagPatterns("tag36h11", {5})->front()); }

PatternState SlantedTag() {
  PatternState state;
  state.tag_from_pixel = *TagFromPixel({{{11, 42}, {37, 45}, {41, 14}, {13, 12}}});
  state.origin = {25, 27};
  state.radius_px = 20;
  state.blur_px2 = {0.6, 0.05, 0.5};
  state.black = 30;
  state.gain = 180;
  state.light = {0.05, -0.03, 0.02};
  return state;
}

TEST(PatternState, JacobianMatchesNumericDifferences) {
  const PatternModel model = TagFive();
  const NormalTable normal;
  const PatternState state = SlantedTag();
  const Eigen::Vector3d blur = state.blur_px2;
  PatternVector worst = PatternVector::Zero(), size = PatternVector::Zero();
  for (int y = 8; y < 50; ++y) {
    for (int x = 8; x < 46; ++x) {
      PatternRow row;
      const Eigen::Vector2d pixel(x, y);
      PredictGrey(model, state, normal, pixel, &row);
      for (int i = 0; i < kPatternUnknowns; ++i) {
        const double h = 1e-5;
        PatternVector step = PatternVector::Zero();
        step[i] = h;
        const double up = PredictGrey(model, Move(state, step), normal, pixel, nullptr);
        const double down = PredictGrey(model, Move(state, -step), normal, pixel, nullptr);
        const double numeric = (up - down) / (2 * h);
        worst[i] = std::max(worst[i], std::abs(numeric - row[static_cast<size_t>(i)]));
        size[i] = std::max(size[i], std::abs(numeric));
      }
    }
  }
  for (int i = 0; i < kPatternUnknowns; ++i) {
    EXPECT_GT(size[i], 1) << i;
    EXPECT_LT(worst[i], (i < 8 ? 0.01 : i < 11 ? 0.1 : 1e-5) * size[i]) << i;
  }
  EXPECT_EQ(state.blur_px2, blur);
}

// In both of its ways: with a sharp image's blur and with a wide one.
TEST(PatternSums, AreThoseOfTheRows) {
  const PatternModel model = TagFive();
  const NormalTable normal;
  for (const double blur_px2 : {0.4, 4.0}) {
    PatternState state = SlantedTag();
    state.blur_px2 = {blur_px2, 0.1, 0.8 * blur_px2};
    PatternPixels pixels;
    pixels.origin = {20, 20};
    PatternSums expected;
    expected.normal.setZero();
    expected.gradient.setZero();
    const double reach = 40;
    for (int y = 8; y < 50; ++y) {
      for (int x = 8; x < 46; ++x) {
        const auto grey = static_cast<uint8_t>((37 * x + 101 * y) % 256);
        pixels.Add(x, y, grey);
        PatternRow row;
        const double predicted = PredictGrey(model, state, normal, Eigen::Vector2d(x, y), &row);
        const double residual = grey - predicted;
        const double rest = 1 - std::min(residual * residual / (reach * reach), 1.0);
        const double weight = rest * rest;
        const Eigen::Map<const PatternVector> j(row.data());
        expected.normal += weight * j * j.transpose();
        expected.gradient += weight * residual * j;
        expected.weight += weight;
        expected.psi2 += weight * residual * weight * residual;
        expected.contradicted += std::abs(residual) > 0.5 * state.gain ? 1 : 0;
      }
    }
    const PatternSums sums = SumPattern(model, normal, pixels, state, reach, 1);
    EXPECT_LT((sums.normal - expected.normal).norm(), 1e-4 * expected.normal.norm());
    EXPECT_LT((sums.gradient - expected.gradient).norm(), 1e-3 * expected.gradient.norm());
    EXPECT_NEAR(sums.weight, expected.weight, 1e-3 * expected.weight);
    EXPECT_NEAR(sums.psi2, expected.psi2, 1e-3 * expected.psi2);
    EXPECT_LE(std::max(sums.contradicted, expected.contradicted) -
                  std::min(sums.contradicted, expected.contradicted),
              2U);
    EXPECT_EQ(sums.used, pixels.size());
  }
}

TEST(PatternState, CornersMoveAsTheirJacobianSays) {
  PatternState state;
  const Corners corners = {{{11, 42}, {37, 45}, {41, 14}, {13, 12}}};
  state.tag_from_pixel = *TagFromPixel(corners);
  Eigen::Matrix<double, 8, 8> jacobian;
  const Corners same = PatternCorners(state, &jacobian);
  EXPECT_LT(Difference(same, corners).norm(), 1e-9);
  for (int i = 0; i < 8; ++i) {
    PatternVector step = PatternVector::Zero();
    step[i] = 1e-6;
    const Eigen::Matrix<double, 8, 1> numeric =
        Difference(PatternCorners(Move(state, step)), PatternCorners(Move(state, -step))) / 2e-6;
    EXPECT_LT((numeric - jacobian.col(i)).norm(), 1e-5 * jacobian.norm()) << i;
  }
}

TEST(PatternState, AQuadThatIsNoneHasNoHomography) {
  EXPECT_FALSE(TagFromPixel({{{0, 0}, {0, 0}, {0, 0}, {0, 0}}}));
  EXPECT_FALSE(TagFromPixel({{{0, 10}, {0, 0}, {10, 0}, {10, 10}}}));  // mirrored
  EXPECT_FALSE(TagFromPixel({{{0, 10}, {10, 0}, {10, 10}, {0, 0}}}));  // crossed
  EXPECT_FALSE(TagFromPixel({{{NAN, 10}, {10, 10}, {10, 0}, {0, 0}}}));
}

}  // namespace
}  // namespace tagtwist::internal::pattern_state_test
