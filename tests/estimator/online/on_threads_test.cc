#include "estimator/jobs/on_threads.h"

#include <gtest/gtest.h>

#include <atomic>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

#include "estimator/batch/batch.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::on_threads_test {
namespace {

TEST(OnThreads, CoverEveryIndexOnce) {
  for (const int threads : {1, 2, 5}) {
    for (const size_t count : {0, 1, 3, 1000}) {
      std::vector<int> visits(count, 0);
      OnThreads(threads)(count, [&](size_t first, size_t last) {
        EXPECT_LT(first, last);
        for (size_t i = first; i < last; ++i) ++visits[i];
      });
      EXPECT_EQ(visits, std::vector<int>(count, 1)) << threads;
    }
  }
}

// Two estimates at a time must not leave OpenCV with the threads of one of them.
TEST(OnThreads, NothingOfTheProcessChanges) {
  const int before = cv::getNumThreads();
  const ForRanges one = OnThreads(1), two = OnThreads(2);
  for (const ForRanges* ranges : {&one, &two}) {
    (*ranges)(8, [before](size_t, size_t) { EXPECT_EQ(cv::getNumThreads(), before); });
  }
  EXPECT_EQ(cv::getNumThreads(), before);
}

TEST(OnThreads, CallsWithinCallsAndFromSeveralThreadsAllEnd) {
  const ForRanges ranges = OnThreads(2);
  std::atomic<int> visits{0};
  const auto nested = [&] {
    ranges(20, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        ranges(10, [&](size_t begin, size_t end) { visits += static_cast<int>(end - begin); });
      }
    });
  };
  std::thread other(nested);
  nested();
  other.join();
  EXPECT_EQ(visits, 2 * 20 * 10);
}

TEST(OnThreads, WhatWorkThrowsTheCallThrows) {
  const ForRanges ranges = OnThreads(2);
  const auto throws = [](size_t first, size_t) {
    if (first > 0) throw std::runtime_error("no");
  };
  EXPECT_THROW(ranges(100, throws), std::runtime_error);
  int visits = 0;
  ranges(1, [&](size_t, size_t) { ++visits; });
  EXPECT_EQ(visits, 1) << "usable afterwards";
}

// Ranges of three from the end on: whatever depends on order or on where ranges end shows.
void BackwardsByThree(size_t count, const std::function<void(size_t, size_t)>& work) {
  for (size_t last = count; last > 0;) {
    const size_t first = last > 3 ? last - 3 : 0;
    work(first, last);
    last = first;
  }
}

TEST(ForRanges, HowABatchIsSplitChangesNoBit) {
  EstimatorSetup setup = CourseSetup();
  const auto flight = DrawFlight(ModelUnder(WhiteNoiseOn::kJerk, 5));
  const auto whole = RunBatch(SetUpOf(setup), setup.options, flight.measurements);
  BatchEstimator by_three(SetUpOf(setup), setup.options, BackwardsByThree);
  for (const FrameMeasurements& m : flight.measurements) by_three.Add(m);
  const auto split = by_three.Solve();
  ASSERT_TRUE(whole && split);
  EXPECT_EQ(whole->noise.corner_sigma_px, split->noise.corner_sigma_px);
  EXPECT_EQ(whole->noise.linear.psd, split->noise.linear.psd);
  EXPECT_EQ(whole->reprojection_px, split->reprojection_px);
  ASSERT_EQ(whole->frames.size(), split->frames.size());
  for (size_t i = 0; i < whole->frames.size(); ++i) {
    const FrameEstimate &a = whole->frames[i], &b = split->frames[i];
    EXPECT_EQ(a.state.world_from_body.params, b.state.world_from_body.params) << i;
    EXPECT_EQ(a.state.twist.v_world, b.state.twist.v_world) << i;
    EXPECT_EQ(a.covariance, b.covariance) << i;
    EXPECT_EQ(a.pose_bound, b.pose_bound) << i;
  }
}

}  // namespace
}  // namespace tagtwist::internal::on_threads_test
