#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Reads little-endian values off the front of bytes; past their end everything is zero and Good()
/// false.
class McapBytes {
 public:
  explicit McapBytes(std::string_view bytes) : rest_(bytes) {}
  template <typename Number>
  Number Take() {
    Number out = 0;
    const std::string_view bytes = Take(sizeof(Number));
    for (size_t i = 0; i < bytes.size(); ++i) {
      out = static_cast<Number>(
          out |
          static_cast<Number>(static_cast<Number>(static_cast<uint8_t>(bytes[i])) << (8 * i)));
    }
    return out;
  }
  std::string_view Take(uint64_t size) {
    if (size > rest_.size()) {
      good_ = false;
      rest_ = {};
      return {};
    }
    const std::string_view out = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return out;
  }
  std::string_view TakeText() { return Take(Take<uint32_t>()); }
  bool Good() const { return good_; }
  size_t left() const { return rest_.size(); }

 private:
  std::string_view rest_;
  bool good_ = true;
};

/// The records in the content of a chunk (https://mcap.dev/spec), or why there are none, without
/// any name.
Result<std::string> UnpackMcapChunk(std::string_view chunk, const Limits& limits = {});

}  // namespace tagtwist::internal
