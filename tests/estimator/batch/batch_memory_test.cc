#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "estimator/batch/batch.h"
#include "tests/support/counted_heap.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::batch_memory_test {
namespace {

// A flight forth and back again, all of it over the mat, of any length.
std::vector<FrameMeasurements> Fly(int frames) {
  constexpr int kOneWay = 125;
  ExactModelOptions model = ModelUnder(WhiteNoiseOn::kJerk, 7);
  model.frames = kOneWay + 1;
  model.max_tags = 10;
  const ExactModelFlight flight = DrawFlight(model);
  std::vector<FrameMeasurements> out;
  for (int i = 0; i < frames; ++i) {
    const int phase = i % (2 * kOneWay);
    out.push_back(flight.measurements[static_cast<size_t>(std::min(phase, 2 * kOneWay - phase))]);
    out.back().t_ns = static_cast<int64_t>(20'000'000) * i;
  }
  return out;
}

// The most that is allocated while a batch of so many frames takes them and is solved.
size_t PeakBytes(int frames) {
  const std::vector<FrameMeasurements> measurements = Fly(frames);
  const size_t before = HeapSoFar().bytes;
  ForgetHeapPeak();
  EXPECT_TRUE(RunBatch(CourseSetUp(), {}, measurements));
  return HeapSoFar().peak_bytes - before;
}

// A pair of states' blocks are 5.2 KB, and that is what must be there once: for the solution's
// covariance. The rest are tags, as measured, as used and as factors.
TEST(BatchMemory, OfAFrameLittleMoreIsThereThanItsSolution) {
  if (!kHeapIsCounted) GTEST_SKIP() << "malloc is the sanitizer's";
  constexpr int kFew = 500, kMany = 1300;
  const auto more = static_cast<double>(PeakBytes(kMany)) - static_cast<double>(PeakBytes(kFew));
  const double of_a_frame = more / (kMany - kFew);
  RecordProperty("bytes_of_a_frame", std::to_string(of_a_frame));
  EXPECT_LT(of_a_frame, 20e3);
  EXPECT_GT(of_a_frame, 5e3) << "there is a solution";
}

}  // namespace
}  // namespace tagtwist::internal::batch_memory_test
