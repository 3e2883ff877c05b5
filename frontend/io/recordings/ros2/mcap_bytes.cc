#include "frontend/io/recordings/ros2/mcap_bytes.h"

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <optional>
#include <string>

#include "frontend/base/printable.h"

namespace tagtwist::internal {
namespace {

std::optional<std::string> Lz4(std::string_view packed, uint64_t size) {
  std::string out(size, '\0');
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) return {};
  size_t written = 0, hint = 1;
  while (!packed.empty() && hint != 0) {
    size_t to = out.size() - written, from = packed.size();
    hint = LZ4F_decompress(context, out.data() + written, &to, packed.data(), &from, nullptr);
    if (LZ4F_isError(hint) != 0 || (to == 0 && from == 0)) break;
    written += to;
    packed.remove_prefix(from);
  }
  LZ4F_freeDecompressionContext(context);
  if (hint != 0 || written != out.size()) return std::nullopt;
  return out;
}

std::optional<std::string> Zstd(std::string_view packed, uint64_t size) {
  std::string out(size, '\0');
  const size_t got = ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size());
  if (ZSTD_isError(got) != 0 || got != size) return std::nullopt;
  return out;
}

}  // namespace

Result<std::string> UnpackMcapChunk(std::string_view chunk, const Limits& limits) {
  McapBytes bytes(chunk);
  bytes.Take(16);  // first and last time
  const auto size = bytes.Take<uint64_t>();
  const auto checksum = bytes.Take<uint32_t>();
  const std::string_view compression = bytes.TakeText();
  const std::string_view packed = bytes.Take(bytes.Take<uint64_t>());
  if (!bytes.Good() || size > static_cast<uint64_t>(limits.record_bytes))
    return Error{"a damaged chunk"};
  if (!MayInflate(packed.size(), size, limits)) {
    return Error{"a chunk that says it unpacks to " +
                 std::to_string(size / std::max<uint64_t>(packed.size(), 1)) + " times its size" +
                 RaisesLimit("inflated_ratio")};
  }
  std::optional<std::string> out;
  if (compression.empty()) {
    if (packed.size() == size) out = std::string(packed);
  } else if (compression == "lz4") {
    out = Lz4(packed, size);
  } else if (compression == "zstd") {
    out = Zstd(packed, size);
  } else {
    return Error{"a chunk in the compression \"" + Printable(compression.substr(0, 20)) +
                 "\", expected lz4, zstd or none"};
  }
  if (!out) return Error{"a damaged chunk"};
  const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(out->data()), out->size());
  if (checksum != 0 && checksum != static_cast<uint32_t>(sum)) {
    return Error{"a chunk whose checksum does not fit"};
  }
  return *out;
}

}  // namespace tagtwist::internal
