#pragma once
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace tagtwist::internal {

/// Numbers off the front of bytes; zeros where there are no more.
class FuzzBytes {
 public:
  explicit FuzzBytes(std::string bytes) : bytes_(std::move(bytes)) {}

  template <typename Number>
  Number Take() {
    Number out{};
    const size_t size = std::min(sizeof(Number), bytes_.size() - at_);
    std::memcpy(&out, bytes_.data() + at_, size);
    at_ += size;
    return out;
  }
  size_t Below(size_t bound) { return Take<uint8_t>() % bound; }
  /// Of 65536 steps from `low` to `high`.
  double Between(double low, double high) {
    return low + (high - low) * Take<uint16_t>() / 65535.0;
  }
  bool IsAtEnd() const { return at_ == bytes_.size(); }
  std::string Rest() const { return bytes_.substr(at_); }

 private:
  std::string bytes_;
  size_t at_ = 0;
};

}  // namespace tagtwist::internal
