#include <gtest/gtest.h>

#include <cmath>

#include "frontend/flow/klt_tracker.h"

namespace tagtwist::internal::klt_options_test {
namespace {

TEST(KltOptions, NamesTheBrokenRule) {
  EXPECT_FALSE(KltOptions().Problem());
  KltOptions options;
  options.window_px = 14;
  EXPECT_EQ(options.Problem().value_or(""), "window_px: expected odd, got 14");
  options = {};
  options.forward_backward_px = std::nan("");
  EXPECT_EQ(options.Problem().value_or(""), "forward_backward_px: expected > 0, got nan");
  options = {};
  options.min_fast_threshold = 30;
  EXPECT_EQ(options.Problem().value_or(""),
            "min_fast_threshold: expected <= fast_threshold (20), got 30");
}

}  // namespace
}  // namespace tagtwist::internal::klt_options_test
