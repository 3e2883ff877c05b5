#include "estimator/live/newest_queue.h"

#include <gtest/gtest.h>

#include <memory>

namespace tagtwist::internal::newest_queue_test {
namespace {

TEST(NewestQueue, KeepsTheOrderWhileThereIsRoom) {
  NewestQueue<int> queue(2);
  EXPECT_FALSE(queue.Pop());
  queue.Push(1);
  queue.Push(2);
  EXPECT_EQ(queue.Pop(), 1);
  queue.Push(3);
  EXPECT_EQ(queue.Pop(), 2);
  EXPECT_EQ(queue.Pop(), 3);
  EXPECT_FALSE(queue.Pop());
  EXPECT_EQ(queue.dropped(), 0u);
}

TEST(NewestQueue, TheNewestWinAndTheOthersAreCounted) {
  NewestQueue<int> queue(2);
  for (int i = 1; i <= 5; ++i) queue.Push(i);
  EXPECT_EQ(queue.dropped(), 3u);
  EXPECT_EQ(queue.Pop(), 4);
  EXPECT_EQ(queue.Pop(), 5);
  EXPECT_FALSE(queue.Pop());
}

TEST(NewestQueue, HoldsOneAtLeastAndWhatCannotBeCopied) {
  NewestQueue<std::unique_ptr<int>> queue(0);
  queue.Push(std::make_unique<int>(1));
  queue.Push(std::make_unique<int>(2));
  EXPECT_EQ(**queue.Pop(), 2);
  EXPECT_EQ(queue.dropped(), 1u);
}

}  // namespace
}  // namespace tagtwist::internal::newest_queue_test
