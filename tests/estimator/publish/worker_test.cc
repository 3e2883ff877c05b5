#include "estimator/publish/worker.h"

#include <gtest/gtest.h>

#include <future>
#include <vector>

namespace tagtwist::internal::worker_test {
namespace {

TEST(Worker, WorksInOrderAndFinishesAll) {
  std::vector<int> done;
  Worker<int> worker(100, false, [&](int value) { done.push_back(value); });
  for (int i = 0; i < 50; ++i) worker.Push(i);
  worker.Finish();
  ASSERT_EQ(done.size(), 50u);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(done[static_cast<size_t>(i)], i);
  EXPECT_EQ(worker.dropped(), 0u);
}

// The work stands still: whoever pushes goes on, and the newest are what is left.
TEST(Worker, ASlowOneCostsNoTimeAndLosesTheOldest) {
  std::promise<void> began, go;
  std::shared_future<void> may_go = go.get_future().share();
  std::vector<int> done;
  Worker<int> worker(3, false, [&](int value) {
    if (value == 0) began.set_value();
    may_go.wait();
    done.push_back(value);
  });
  worker.Push(0);
  began.get_future().wait();
  for (int i = 1; i <= 10; ++i) worker.Push(i);
  go.set_value();
  worker.Finish();
  EXPECT_EQ(done, (std::vector<int>{0, 8, 9, 10}));
  EXPECT_EQ(worker.dropped(), 7u);
}

TEST(Worker, OneThatWaitsLosesNothing) {
  std::vector<int> done;
  Worker<int> worker(1, true, [&](int value) { done.push_back(value); });
  for (int i = 0; i < 1000; ++i) worker.Push(i);
  worker.Finish();
  EXPECT_EQ(done.size(), 1000u);
  EXPECT_EQ(worker.dropped(), 0u);
}

}  // namespace
}  // namespace tagtwist::internal::worker_test
