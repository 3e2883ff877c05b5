#pragma once
#include <cstddef>
#include <utility>
#include <vector>

namespace tagtwist::internal {

/// Some of all values that were added, evenly spread over them: every one until there are kMost,
/// then every second, and so on. Memory stays bounded however many come. Samples of equally many
/// values have those of the same places.
template <typename T, size_t kMost = 4096>
class ThinnedSample {
 public:
  explicit ThinnedSample(size_t most = kMost) : most_(most) {}
  void Add(const T& value) {
    if (count_++ % stride_ != 0) return;
    values_.push_back(value);
    if (values_.size() < most_) return;
    for (size_t i = 1; 2 * i < values_.size(); ++i) values_[i] = std::move(values_[2 * i]);
    values_.resize((values_.size() + 1) / 2);
    stride_ *= 2;
  }

  const std::vector<T>& values() const { return values_; }
  std::vector<T> Take() { return std::move(values_); }
  /// How many were added.
  size_t count() const { return count_; }
  /// How many were added for each that is kept.
  size_t stride() const { return stride_; }

 private:
  size_t most_, count_ = 0, stride_ = 1;
  std::vector<T> values_;
};

}  // namespace tagtwist::internal
