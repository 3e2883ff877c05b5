#include "estimator/window/stamp_check.h"

#include <gtest/gtest.h>

namespace tagtwist::internal::stamp_check_test {
namespace {

constexpr int64_t kMs = 1'000'000;

TEST(StampCheck, EveryOtherFrameOfPairsComesTooSoon) {
  StampCheck check;
  int too_soon = 0;
  for (int64_t pair = 0; pair < 50; ++pair) {
    check.ComesTooSoon(66 * pair * kMs);
    too_soon += check.ComesTooSoon(66 * pair * kMs + kMs / 2) ? 1 : 0;
  }
  EXPECT_GE(too_soon, 45);  // the first ones show what is usual
  ASSERT_TRUE(check.Warning());
  EXPECT_NE(check.Warning()->find(std::to_string(too_soon) + " frames"), std::string::npos);
}

TEST(StampCheck, GapsJitterAndOtherRatesAreNoBursts) {
  StampCheck check;
  int64_t t_ns = 0;
  for (int64_t i = 0; i < 300; ++i) {
    EXPECT_FALSE(check.ComesTooSoon(t_ns)) << i;
    // 30 Hz with a third of jitter, a gap, then 120 Hz.
    t_ns += i == 100 ? 20'000 * kMs : i < 200 ? (i % 2 == 0 ? 22 : 44) * kMs : 8 * kMs;
  }
  EXPECT_FALSE(check.Warning());
}

}  // namespace
}  // namespace tagtwist::internal::stamp_check_test
