#include <gtest/gtest.h>
#include <malloc.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "estimator/window/sliding_window.h"
#include "tests/support/counted_heap.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::window_memory_test {
namespace {

constexpr int kLap = 250;

// A window over laps forth and back again: a flight of any length in a small memory.
class Laps {
 public:
  Laps() : model_(MakeModel()), flight_(DrawFlight(model_)) {
    window_.emplace(CourseSetUp(), GivenNoise(model_));
  }

  void Fly() {
    for (int phase = 0; phase < kLap; ++phase, ++n_frames_) {
      const auto k = static_cast<size_t>(phase <= kLap / 2 ? phase : kLap - phase);
      FrameMeasurements measurement = flight_.measurements[k];
      measurement.t_ns = static_cast<int64_t>(20'000'000) * n_frames_;
      const auto output = window_->Add(measurement);
      ASSERT_TRUE(output) << output.error().message;
    }
  }

 private:
  static ExactModelOptions MakeModel() {
    ExactModelOptions model = ModelUnder(WhiteNoiseOn::kJerk, 7);
    model.frames = kLap / 2 + 1;
    return model;
  }

  ExactModelOptions model_;
  ExactModelFlight flight_;
  std::optional<SlidingWindow> window_;
  int n_frames_ = 0;
};

// Bytes that malloc has given out; nothing where something else allocates, as under the sanitizers.
size_t AllocatedBytes() { return mallinfo2().uordblks; }

TEST(WindowMemory, DoesNotGrowWithTheFlight) {
  if (AllocatedBytes() == 0) GTEST_SKIP() << "malloc is not the C library's";
  Laps laps;
  for (int lap = 0; lap < 2; ++lap) laps.Fly();
  const size_t settled = AllocatedBytes();
  for (int lap = 0; lap < 6; ++lap) laps.Fly();
  constexpr size_t kSlack = 64 * 1024;  // the window itself holds some 200 KiB
  EXPECT_LT(AllocatedBytes(), settled + kSlack);
}

// None would be best. Most are those of residuals, which Ceres' base class keeps the sizes of, and
// of what lens and map err by, which is learned at every few frames, at first more often.
TEST(WindowMemory, AllocationsOfAFrameAreFewAndNoMoreAsItFlies) {
  if (!kHeapIsCounted) GTEST_SKIP() << "malloc is the sanitizer's";
  Laps laps;
  for (int lap = 0; lap < 6; ++lap) laps.Fly();
  const auto of_a_frame = [&] {
    const size_t before = HeapSoFar().allocations;
    laps.Fly();
    return static_cast<double>(HeapSoFar().allocations - before) / kLap;
  };
  const double first = of_a_frame(), second = of_a_frame();
  RecordProperty("allocations_of_a_frame", std::to_string(second));
  EXPECT_GT(first, 0);
  EXPECT_LT(first, 235);
  EXPECT_LT(second, 1.02 * first);
}

}  // namespace
}  // namespace tagtwist::internal::window_memory_test
