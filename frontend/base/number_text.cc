#include "frontend/base/number_text.h"

#include <array>
#include <charconv>
#include <cmath>

namespace tagtwist::internal {
namespace {

constexpr int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr int64_t kMaxSeconds = kMostStampNs / kNanosecondsPerSecond - 1;

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

std::string_view WithoutPlus(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+';
  return plus ? text.substr(1) : text;
}

std::optional<int64_t> SecondsFromDouble(std::string_view text) {
  const auto seconds = ParseNumber(text);
  if (!seconds || !(std::abs(*seconds) <= static_cast<double>(kMaxSeconds))) return std::nullopt;
  return std::llround(*seconds * 1e9);
}

}  // namespace

std::optional<double> ParseNumber(std::string_view text) {
  text = WithoutPlus(text);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (!std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<int64_t> ParseInteger(std::string_view text) {
  text = WithoutPlus(text);
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<int64_t> ParseSeconds(std::string_view text) {
  const std::string_view whole_text = text;
  const bool negative = !text.empty() && text[0] == '-';
  text = negative ? text.substr(1) : WithoutPlus(text);
  int64_t seconds = 0;
  size_t i = 0;
  for (; i < text.size() && IsDigit(text[i]); ++i) {
    seconds = 10 * seconds + (text[i] - '0');
    if (seconds > kMaxSeconds) return std::nullopt;
  }
  const size_t whole_digits = i;
  int64_t nanoseconds = 0;
  size_t decimals = 0;
  if (i < text.size() && text[i] == '.') {
    int64_t unit = kNanosecondsPerSecond;
    for (++i; i < text.size() && IsDigit(text[i]); ++i, ++decimals) {
      unit /= 10;  // 0 from the tenth decimal on
      nanoseconds += unit * (text[i] - '0');
      if (decimals == 9 && text[i] >= '5') ++nanoseconds;  // the tenth decides alone
    }
  }
  if (whole_digits + decimals == 0 || i != text.size()) return SecondsFromDouble(whole_text);
  const int64_t total = seconds * kNanosecondsPerSecond + nanoseconds;
  return negative ? -total : total;
}

std::string FormatSeconds(int64_t t_ns) {
  const bool negative = t_ns < 0;
  const uint64_t size = negative ? 0 - static_cast<uint64_t>(t_ns) : static_cast<uint64_t>(t_ns);
  std::string decimals = std::to_string(size % kNanosecondsPerSecond);
  decimals.insert(0, 9 - decimals.size(), '0');
  return (negative ? "-" : "") + std::to_string(size / kNanosecondsPerSecond) + "." + decimals;
}

std::string FormatNumber(double value) {
  std::array<char, 40> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return std::string(buffer.data(), end);
}

std::string QuoteForMessage(std::string_view text) {
  constexpr size_t kLongest = 40;
  std::string out = "'";
  for (const char c : text.substr(0, kLongest)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + (text.size() > kLongest ? "...'" : "'");
}

}  // namespace tagtwist::internal
