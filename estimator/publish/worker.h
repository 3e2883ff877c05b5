#pragma once
#include <sys/resource.h>

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "estimator/live/newest_queue.h"

namespace tagtwist::internal {

/// A thread that works on what is handed to it, in order. Who hands it on never waits: when `most`
/// values wait already, the one that waited longest is dropped and counted. With `waits` it is the
/// other way round: nothing is dropped, and who hands on waits. `niceness`: how far the thread
/// gives way to those of other work, as of nice(1).
template <typename T>
class Worker {
 public:
  Worker(size_t most, bool waits, std::function<void(T)> work, int niceness = 0)
      : most_(most), waits_(waits), niceness_(niceness), work_(std::move(work)), waiting_(most) {
    thread_ = std::thread([this] { Run(); });
  }
  ~Worker() { Finish(); }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void Push(T value) {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      if (waits_) changed_.wait(lock, [this] { return waiting_.size() < most_; });
      waiting_.Push(std::move(value));
    }
    changed_.notify_all();
  }
  /// Ends the thread when all that waits is done; nothing may be handed to it afterwards.
  void Finish() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }
  size_t dropped() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return waiting_.dropped();
  }

 private:
  void Run() {
    // Of this thread alone: Linux knows no other. Where it may not be, it is not.
    if (niceness_ != 0) static_cast<void>(::setpriority(PRIO_PROCESS, 0, niceness_));
    while (true) {
      std::optional<T> value;
      {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait(lock, [this] { return ended_ || waiting_.size() > 0; });
        value = waiting_.Pop();
      }
      if (!value) return;
      changed_.notify_all();
      work_(std::move(*value));
    }
  }

  size_t most_;
  bool waits_;
  int niceness_;
  std::function<void(T)> work_;
  mutable std::mutex mutex_;  // of all that follows
  std::condition_variable changed_;
  NewestQueue<T> waiting_;
  bool ended_ = false;
  std::thread thread_;  // last member: it uses the others
};

}  // namespace tagtwist::internal
