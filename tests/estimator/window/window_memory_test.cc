#include <gtest/gtest.h>
#include <malloc.h>

#include "estimator/window/sliding_window.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::window_memory_test {
namespace {

// Bytes that malloc has given out; nothing where something else allocates, as under the sanitizers.
size_t AllocatedBytes() { return mallinfo2().uordblks; }

TEST(WindowMemory, DoesNotGrowWithTheFlight) {
  if (AllocatedBytes() == 0) GTEST_SKIP() << "malloc is not the C library's";
  constexpr int kLap = 250, kSettled = 2 * kLap, kLaps = 8;
  ExactModelOptions model = ModelUnder(WhiteNoiseOn::kJerk, 7);
  model.frames = kLap / 2 + 1;
  const ExactModelFlight flight = DrawFlight(model);
  SlidingWindow window(CourseSetUp(), GivenNoise(model));
  size_t settled = 0, allocated = 0;
  for (int i = 0; i < kLaps * kLap; ++i) {
    // Forth and back again: a flight of any length in a small memory.
    const int phase = i % kLap;
    const auto k = static_cast<size_t>(phase <= kLap / 2 ? phase : kLap - phase);
    FrameMeasurements measurement = flight.measurements[k];
    measurement.t_ns = static_cast<int64_t>(20'000'000) * i;
    const auto output = window.Add(measurement);
    ASSERT_TRUE(output) << output.error().message;
    if (i + 1 == kSettled) settled = AllocatedBytes();
  }
  allocated = AllocatedBytes();
  constexpr size_t kSlack = 64 * 1024;  // the window itself holds some 200 KiB
  EXPECT_LT(allocated, settled + kSlack);
}

}  // namespace
}  // namespace tagtwist::internal::window_memory_test
