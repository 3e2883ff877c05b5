#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tagtwist::internal {

/// Finite number that fills the text (a leading + is allowed); nullopt otherwise.
std::optional<double> ParseNumber(std::string_view text);
std::optional<int64_t> ParseInteger(std::string_view text);

/// Stamps lie at most that far from zero, 145 years, so that the difference of any two is a number,
/// too [ns]. Texts that say more are no stamps.
inline constexpr int64_t kMostStampNs = 4'600'000'000'000'000'000;

/// Decimal seconds to nanoseconds, exactly: "1499735676.510662" is 1499735676510662000. Digits past
/// the ninth decimal round, half away from zero. A text with an exponent goes through a double.
std::optional<int64_t> ParseSeconds(std::string_view text);

/// Nanoseconds as seconds with nine decimals; ParseSeconds is its inverse.
std::string FormatSeconds(int64_t t_ns);

/// The shortest text that reads back as the same double.
std::string FormatNumber(double value);

/// A value quoted for a message: cut to 40 characters, unprintable ones shown as '?'.
std::string QuoteForMessage(std::string_view text);

}  // namespace tagtwist::internal
