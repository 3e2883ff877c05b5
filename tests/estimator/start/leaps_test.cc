#include "estimator/start/leaps.h"

#include <gtest/gtest.h>

namespace tagtwist::internal::leaps_test {
namespace {

std::vector<GraphFrame> SlowFrames(size_t n) {
  std::vector<GraphFrame> out(n);
  for (GraphFrame& frame : out) {
    frame.tags.resize(1);
    frame.state.twist.v_world = {3, 4, 0};
    frame.state.twist.omega_body = {0, 0, 12};
  }
  return out;
}

TEST(Leaps, LoneTagsThatNoBodyCouldFollowAreDropped) {
  std::vector<GraphFrame> frames = SlowFrames(200);
  EXPECT_FALSE(DropBeyondReach(&frames));
  frames[50].state.twist.v_world = {0, 36, 0};
  frames[51].state.twist.omega_body = {0, 21, 0};
  frames[52].state.twist.v_world = {0, 36, 0};
  frames[52].tags.resize(2);  // which agree
  EXPECT_TRUE(DropBeyondReach(&frames));
  EXPECT_TRUE(frames[50].tags.empty());
  EXPECT_TRUE(frames[51].tags.empty());
  EXPECT_EQ(frames[52].tags.size(), 2U);
  EXPECT_EQ(frames[49].tags.size(), 1U);
  EXPECT_FALSE(DropBeyondReach(&frames));
}

TEST(Leaps, ABodyThatIsOftenSoFastIs) {
  std::vector<GraphFrame> frames = SlowFrames(200);
  for (size_t k = 40; k < 60; ++k) frames[k].state.twist.omega_body = {0, 0, 25};
  EXPECT_FALSE(DropBeyondReach(&frames));
  EXPECT_EQ(frames[50].tags.size(), 1U);
}

}  // namespace
}  // namespace tagtwist::internal::leaps_test
