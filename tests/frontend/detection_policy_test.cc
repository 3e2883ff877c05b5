#include "frontend/tags/detection_policy.h"

#include <gtest/gtest.h>

#include <vector>

namespace tagtwist::internal::detection_policy_test {
namespace {

TEST(DetectionPolicy, LostWhereNoneOrFewerThanHalfAreFound) {
  DetectionPolicy policy;
  policy.AfterFull(10);
  EXPECT_FALSE(policy.AfterGuided(10, 10));
  EXPECT_FALSE(policy.AfterGuided(10, 5));
  EXPECT_TRUE(policy.AfterGuided(10, 2));
  EXPECT_TRUE(policy.AfterGuided(10, 0));
  EXPECT_TRUE(policy.AfterGuided(0, 0)) << "nothing is expected, so nothing guides";
}

TEST(DetectionPolicy, WhatAFullSearchDoesNotFindEitherIsNoLoss) {
  DetectionPolicy policy;
  policy.AfterFull(10);
  EXPECT_TRUE(policy.AfterGuided(10, 2));
  policy.AfterFull(2);  // the others are covered
  EXPECT_FALSE(policy.AfterGuided(10, 2));
  EXPECT_FALSE(policy.AfterGuided(10, 1));
}

TEST(DetectionPolicy, TagsThatLeaveTheImageAreNoLoss) {
  DetectionPolicy policy;
  policy.AfterFull(10);
  EXPECT_FALSE(policy.AfterGuided(4, 4));
  EXPECT_FALSE(policy.AfterGuided(1, 1));
}

// Parts come one at a time with frames between them, and every place, with a tag of a tenth of the
// image around it, lies in one of them within a hundred frames.
TEST(DetectionPolicy, PartsCoverTheImageInTurn) {
  DetectionPolicy policy;
  policy.AfterFull(5);
  std::vector<Eigen::AlignedBox2d> parts;
  int last = -10;
  for (int frame = 0; frame < 100; ++frame) {
    const auto part = policy.NextPart();
    if (!part) continue;
    EXPECT_GE(frame - last, 4);
    EXPECT_LT(part->volume(), 0.2);
    EXPECT_TRUE(Eigen::AlignedBox2d(Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 1)).contains(*part));
    last = frame;
    parts.push_back(*part);
  }
  const Eigen::Vector2d margin(0.05, 0.05);
  for (double x = 0.05; x < 0.95; x += 0.01) {
    for (double y = 0.05; y < 0.95; y += 0.01) {
      const Eigen::Vector2d at(x, y);
      const Eigen::AlignedBox2d tag(at - margin, at + margin);
      EXPECT_TRUE(std::any_of(parts.begin(), parts.end(), [&](const auto& part) {
        return part.contains(tag);
      })) << at.transpose();
    }
  }
}

TEST(DetectionPolicy, AFullSearchPutsThePartsOff) {
  DetectionPolicy policy;
  for (int frame = 0; frame < 100; ++frame) {
    if (frame % 4 == 0) policy.AfterFull(5);
    EXPECT_FALSE(policy.NextPart());
  }
}

}  // namespace
}  // namespace tagtwist::internal::detection_policy_test
