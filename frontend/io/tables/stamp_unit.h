#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tagtwist::internal {

/// What a clock's numbers count.
enum class StampUnit { kSeconds, kMilliseconds, kMicroseconds, kNanoseconds };

/// "seconds", "milliseconds", ...
const char* ToString(StampUnit unit);
/// Seconds in one of them.
double SecondsIn(StampUnit unit);

/// The unit under which such numbers lie between the years 2000 and 2100 when they count from 1970;
/// nullopt when none does. No two units share a number.
std::optional<StampUnit> UnitOfUnixTime(double number);

/// The unit under which numbers that far apart come at 1 to 1000 a second (1 included).
std::optional<StampUnit> UnitOfInterval(double interval);

/// A stamp in nanoseconds, exactly where its text is a decimal; nullopt for what is no time.
std::optional<int64_t> ParseStamp(std::string_view text, StampUnit unit);

/// Median of the growing steps between neighbours; 0 where none grows.
double MedianStep(const std::vector<double>& numbers);

/// Why `numbers`, the stamps of a recording that by its format count `declared`, cannot do so, and
/// what they would be: "as nanoseconds they come 5000 times a second, as microseconds 5 times a
/// second in 2013". Only numbers that cannot be right are accused: faster than 20 kHz or more than
/// three thousand years ahead, or, where they are a date under another unit and none under the
/// declared one, faster than 2 kHz or slower than one in 500 s. nullopt: nothing speaks against
/// them.
struct WrongUnit {
  StampUnit implied;
  std::string words;
};
std::optional<WrongUnit> FindWrongUnit(const std::vector<double>& numbers, StampUnit declared);

}  // namespace tagtwist::internal
