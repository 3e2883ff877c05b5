// What is made of the times that a video's container gives, or does not give. Whole files are read
// in the programs' tests.
#include "frontend/io/images/video_times.h"

#include <gtest/gtest.h>

namespace tagtwist::video_times_test {
namespace {

using Stamps = std::vector<int64_t>;

TEST(VideoTimes, TimesThatGrowAreKept) {
  const auto repaired = RepairStamps({{0, 10, 35, 40}, 30, 1, 0});
  ASSERT_TRUE(repaired);
  EXPECT_EQ(repaired->stamps_ns, (Stamps{0, 10, 35, 40}));
  EXPECT_EQ(repaired->invented + repaired->dropped, 0U);
}

TEST(VideoTimes, OnlyTheTailWithoutTimesIsInvented) {
  const auto repaired = RepairStamps({{0, 10, 35, 45, {}, {}}, 1000, 1, 0});
  ASSERT_TRUE(repaired);
  EXPECT_EQ(repaired->stamps_ns, (Stamps{0, 10, 35, 45, 55, 65}));
  EXPECT_EQ(repaired->invented, 2U);
}

TEST(VideoTimes, FramesThatDoNotGrowAreDropped) {
  const auto repaired = RepairStamps({{0, 10, 10, 5, 20}, 30, 1, 0});
  ASSERT_TRUE(repaired);
  EXPECT_EQ(repaired->stamps_ns, (Stamps{0, 10, 20}));
  EXPECT_EQ(repaired->kept, (std::vector<bool>{true, true, false, false, true}));
  EXPECT_EQ(repaired->dropped, 2U);
}

TEST(VideoTimes, WithoutAnyTimeTheRateCounts) {
  const auto repaired = RepairStamps({{{}, {}, {}}, 50, 0, 0});
  ASSERT_TRUE(repaired);
  EXPECT_TRUE(repaired->by_rate);
  EXPECT_EQ(repaired->stamps_ns, (Stamps{0, 20000000, 40000000}));
  EXPECT_FALSE(RepairStamps({{{}, {}}, 0, 0, 0}));
}

}  // namespace
}  // namespace tagtwist::video_times_test
