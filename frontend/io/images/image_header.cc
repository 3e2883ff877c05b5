#include "frontend/io/images/image_header.h"

#include <algorithm>
#include <cctype>

namespace tagtwist::internal {
namespace {

// An unsigned number of up to four bytes; 0 past the end.
uint64_t Number(std::string_view bytes, size_t at, size_t size, bool big_endian) {
  if (at > bytes.size() || bytes.size() - at < size) return 0;
  uint64_t value = 0;
  for (size_t i = 0; i < size; ++i) {
    const size_t k = big_endian ? i : size - 1 - i;
    value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
  }
  return value;
}

bool StartsWith(std::string_view bytes, std::string_view magic) {
  return bytes.substr(0, magic.size()) == magic;
}

// The frame header's segment, among those before the first scan.
std::optional<ImageHeader> OfJpeg(std::string_view bytes) {
  for (size_t at = 2; at + 9 <= bytes.size();) {
    if (bytes[at] != '\xFF') return std::nullopt;
    const auto marker = static_cast<unsigned char>(bytes[at + 1]);
    if (marker == 0xFF) {
      ++at;
      continue;
    }
    const bool frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (frame) return ImageHeader{Number(bytes, at + 7, 2, true), Number(bytes, at + 5, 2, true)};
    const bool bare = (marker >= 0xD0 && marker <= 0xD8) || marker == 0x01;
    at += 2 + (bare ? 0 : Number(bytes, at + 2, 2, true));
  }
  return std::nullopt;
}

// Entries 256 and 257 of the first directory.
std::optional<ImageHeader> OfTiff(std::string_view bytes) {
  const bool big_endian = bytes[0] == 'M';
  const size_t directory = Number(bytes, 4, 4, big_endian);
  const size_t entries = Number(bytes, directory, 2, big_endian);
  ImageHeader out;
  for (size_t i = 0; i < entries; ++i) {
    const size_t at = directory + 2 + 12 * i;
    const uint64_t tag = Number(bytes, at, 2, big_endian);
    const size_t size = Number(bytes, at + 2, 2, big_endian) == 3 ? 2 : 4;
    if (tag == 256) out.width = Number(bytes, at + 8, size, big_endian);
    if (tag == 257) out.height = Number(bytes, at + 8, size, big_endian);
  }
  if (out.width == 0 || out.height == 0) return std::nullopt;
  return out;
}

// Two numbers after the magic one, apart by blanks and comments; a third, the largest value, where
// pixels are more than bits.
std::optional<ImageHeader> OfPnm(std::string_view bytes) {
  size_t at = 2;
  if (at >= bytes.size() || std::isspace(static_cast<unsigned char>(bytes[at])) == 0) {
    return std::nullopt;
  }
  const auto next = [&]() -> uint64_t {
    while (at < bytes.size() &&
           (std::isspace(static_cast<unsigned char>(bytes[at])) != 0 || bytes[at] == '#')) {
      if (bytes[at] == '#') at = std::min(bytes.find('\n', at), bytes.size() - 1);
      ++at;
    }
    uint64_t value = 0;
    for (; at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9'; ++at) {
      value = std::min<uint64_t>(10 * value + static_cast<uint64_t>(bytes[at] - '0'), 1U << 31);
    }
    return value;
  };
  ImageHeader out;
  out.width = next();
  out.height = next();
  if (out.width == 0 || out.height == 0) return std::nullopt;
  const char kind = bytes[1];
  const bool bits = kind == '1' || kind == '4';
  const uint64_t most = bits ? 1 : next();
  if (most == 0 || most > 65535) return std::nullopt;
  const uint64_t samples = out.width * (kind == '3' || kind == '6' ? 3 : 1);
  const uint64_t row =
      kind == '4' ? (samples + 7) / 8 : samples * (kind > '4' && most > 255 ? 2 : 1);
  out.least_bytes = at + row * out.height;
  return out;
}

// Of a file that libwebp takes for one.
std::optional<ImageHeader> OfWebp(std::string_view bytes) {
  const std::string_view kind = bytes.substr(12, 4);
  if (kind == "VP8X" && Number(bytes, 16, 4, false) == 10) {
    return ImageHeader{Number(bytes, 24, 3, false) + 1, Number(bytes, 27, 3, false) + 1};
  }
  if (kind == "VP8L" && bytes[20] == 0x2F) {
    const uint64_t bits = Number(bytes, 21, 4, false);
    return ImageHeader{(bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1};
  }
  const bool is_key_frame = (Number(bytes, 20, 1, false) & 1) == 0;
  if (kind == "VP8 " && is_key_frame && bytes.substr(23, 3) == "\x9D\x01\x2A") {
    return ImageHeader{Number(bytes, 26, 2, false) & 0x3FFF, Number(bytes, 28, 2, false) & 0x3FFF};
  }
  return std::nullopt;
}

// A BMP's height is negative where its rows come from the top.
ImageHeader OfBmp(std::string_view bytes) {
  const auto size = [&](size_t at) -> uint64_t {
    const auto value = static_cast<int32_t>(Number(bytes, at, 4, false));
    return static_cast<uint64_t>(value < 0 ? -static_cast<int64_t>(value) : value);
  };
  return {size(18), size(22)};
}

}  // namespace

bool BeginsAsPnm(std::string_view bytes) {
  return bytes.size() > 1 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6';
}

namespace {

std::optional<ImageHeader> OfAnyFormat(std::string_view bytes) {
  constexpr size_t kLeastBytes = 30;
  if (BeginsAsPnm(bytes)) return OfPnm(bytes);
  if (bytes.size() < kLeastBytes) return std::nullopt;
  if (StartsWith(bytes, "\x89PNG\r\n\x1a\n")) {
    return ImageHeader{Number(bytes, 16, 4, true), Number(bytes, 20, 4, true)};
  }
  if (StartsWith(bytes, "\xFF\xD8\xFF")) return OfJpeg(bytes);
  if (StartsWith(bytes, {"II*\0", 4}) || StartsWith(bytes, {"MM\0*", 4})) return OfTiff(bytes);
  if (StartsWith(bytes, "BM")) return OfBmp(bytes);
  if (StartsWith(bytes, "RIFF") && bytes.substr(8, 4) == "WEBP") return OfWebp(bytes);
  return std::nullopt;
}

}  // namespace

std::optional<ImageHeader> ReadImageHeader(std::string_view bytes) {
  const auto header = OfAnyFormat(bytes);
  return header && header->width > 0 && header->height > 0 ? header : std::nullopt;
}

}  // namespace tagtwist::internal
