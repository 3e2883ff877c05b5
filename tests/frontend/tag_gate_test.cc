#include "frontend/geometry/tag_gate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "frontend/base/statistics/quantile.h"
#include "frontend/geometry/quad_shape.h"
#include "tests/support/flights/tag_views.h"

namespace tagtwist::internal::tag_gate_test {
namespace {

TEST(SquareMisfit, HasTwoDegreesOfFreedomLeft) {
  constexpr double kNoisePx = 0.2;
  double sum = 0;
  std::vector<double> approximations;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const TagViews views = DrawViews(TagPlaces::kWall, seed, kNoisePx);
    for (const auto& tags : views.frames) {
      for (const TagDetection& tag : tags) {
        const double misfit = *SquareMisfitPx(tag.corners, views.camera);
        const double about = *ApproximateSquareMisfitPx(tag.corners, views.camera);
        sum += misfit * misfit / (kNoisePx * kNoisePx);
        approximations.push_back(about * about / (kNoisePx * kNoisePx));
      }
    }
  }
  ASSERT_GT(approximations.size(), 3000u);
  EXPECT_NEAR(sum / static_cast<double>(approximations.size()), 2, 0.1);
  EXPECT_NEAR(Quantile(approximations, 0.5), 2 * std::log(2), 0.2);
}

TEST(SquareMisfit, IsOfTheSizeOfABend) {
  const TagViews views = DrawViews(TagPlaces::kFloor, 3, 0);
  for (TagDetection tag : views.frames[0]) {
    EXPECT_LT(*SquareMisfitPx(tag.corners, views.camera), 1e-4);
    tag.corners[2] += Eigen::Vector2d(-6, 3);
    const double misfit = *SquareMisfitPx(tag.corners, views.camera);
    EXPECT_GT(misfit, 1);
    EXPECT_LT(misfit, 7);
  }
}

TEST(TurnOf, IsTheCornersSenseAsSeen) {
  const std::array<Eigen::Vector2d, 4> seen = {Eigen::Vector2d(0, 50), {50, 50}, {50, 0}, {0, 0}};
  EXPECT_EQ(TurnOf(seen), QuadTurn::kAnticlockwise);
  EXPECT_EQ(TurnOf({seen[3], seen[2], seen[1], seen[0]}), QuadTurn::kClockwise);
  EXPECT_EQ(TurnOf({seen[0], seen[2], seen[1], seen[3]}), QuadTurn::kFlat);  // crosses itself
  EXPECT_EQ(TurnOf({seen[0], seen[1], {20, 35}, seen[3]}), QuadTurn::kNone);
  EXPECT_EQ(TurnOf({seen[0], seen[1], {50, 48}, {0, 48}}), QuadTurn::kFlat);
  EXPECT_EQ(TurnOf({seen[0], seen[1], {NAN, 48}, {0, 48}}), QuadTurn::kNone);
}

TEST(TagGate, LetsRightTagsPass) {
  for (const double noise_px : {0.05, 0.2, 1.0}) {
    size_t n = 0, refused = 0;
    for (unsigned seed = 1; seed <= 30; ++seed) {
      const TagViews views = DrawViews(TagPlaces::kRoom, seed, noise_px);
      TagGate gate(views.map, views.camera);
      for (auto tags : views.frames) {
        n += tags.size();
        refused += gate.TakeRefused(&tags).size();
      }
    }
    EXPECT_GT(n, 5000u);
    EXPECT_LE(refused, n / 5000) << noise_px;
  }
}

TEST(TagGate, RefusesPhantoms) {
  size_t n = 0, refused = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const TagViews views = DrawViews(TagPlaces::kFloor, seed);
    TagGate gate(views.map, views.camera);
    std::mt19937_64 engine(seed);
    for (auto tags : views.frames) {
      gate.TakeRefused(&tags);
      std::vector<TagDetection> phantom = {DrawPhantom(views, &engine)};
      refused += gate.TakeRefused(&phantom).size();
      ++n;
    }
  }
  EXPECT_GE(refused, n * 95 / 100);
}

// As a border or a hand bends them: one corner, or two, drawn towards the tag's middle.
TEST(TagGate, RefusesCornersThatAreBentInwards) {
  size_t n = 0, refused = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const TagViews views = DrawViews(TagPlaces::kFloor, seed);
    TagGate gate(views.map, views.camera);
    for (auto tags : views.frames) {
      gate.TakeRefused(&tags);
      if (tags.size() > 2) tags.resize(2);
      for (TagDetection tag : tags) {
        const Eigen::Vector2d middle = 0.5 * (tag.corners[0] + tag.corners[2]);
        Eigen::Vector2d& corner = tag.corners[seed % 4];
        corner += 6 * (middle - corner).normalized();
        std::vector<TagDetection> bent = {tag};
        refused += gate.TakeRefused(&bent).size();
        ++n;
      }
    }
  }
  // One in ten looks like another tilt.
  EXPECT_GE(refused, n * 8 / 10);
}

}  // namespace
}  // namespace tagtwist::internal::tag_gate_test
