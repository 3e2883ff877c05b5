#pragma once
#include <algorithm>
#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

namespace tagtwist::internal {

/// What waits for a consumer that may be too slow: at most `most` values, in order. The newest win:
/// a value that comes when the queue is full drops the one that waited longest.
template <typename T>
class NewestQueue {
 public:
  explicit NewestQueue(size_t most) : most_(std::max<size_t>(most, 1)) {}

  void Push(T value) {
    if (waiting_.size() == most_) {
      waiting_.pop_front();
      ++dropped_;
    }
    waiting_.push_back(std::move(value));
  }
  /// The one that waited longest.
  std::optional<T> Pop() {
    if (waiting_.empty()) return std::nullopt;
    std::optional<T> out = std::move(waiting_.front());
    waiting_.pop_front();
    return out;
  }
  size_t size() const { return waiting_.size(); }
  size_t dropped() const { return dropped_; }

 private:
  size_t most_;
  std::deque<T> waiting_;
  size_t dropped_ = 0;
};

}  // namespace tagtwist::internal
