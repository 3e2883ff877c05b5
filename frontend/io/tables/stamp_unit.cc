#include "frontend/io/tables/stamp_unit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

constexpr std::array<StampUnit, 4> kUnits = {StampUnit::kSeconds, StampUnit::kMilliseconds,
                                             StampUnit::kMicroseconds, StampUnit::kNanoseconds};
constexpr double kYearS = 365.25 * 86400;
constexpr double kYear2000S = 946684800, kYear2100S = 4102444800;

std::string RateText(double rate_hz) {
  std::array<char, 64> text{};
  const bool fast = rate_hz >= 1;
  std::snprintf(text.data(), text.size(), fast ? "%.3g Hz" : "one in %.3g s",
                fast ? rate_hz : 1 / rate_hz);
  return text.data();
}

// `unix_time`: the number of a date; 0: none is told.
std::string Words(StampUnit unit, double interval, double unix_time) {
  std::string out = std::string("as ") + ToString(unit) + " they come at " +
                    RateText(1 / (interval * SecondsIn(unit)));
  if (unix_time > 0) {
    out += " in " + std::to_string(1970 + static_cast<int>(unix_time * SecondsIn(unit) / kYearS));
  }
  return out;
}

}  // namespace

const char* ToString(StampUnit unit) {
  switch (unit) {
    case StampUnit::kSeconds:
      return "seconds";
    case StampUnit::kMilliseconds:
      return "milliseconds";
    case StampUnit::kMicroseconds:
      return "microseconds";
    case StampUnit::kNanoseconds:
      return "nanoseconds";
  }
  return "";
}

double SecondsIn(StampUnit unit) {
  switch (unit) {
    case StampUnit::kSeconds:
      return 1;
    case StampUnit::kMilliseconds:
      return 1e-3;
    case StampUnit::kMicroseconds:
      return 1e-6;
    case StampUnit::kNanoseconds:
      return 1e-9;
  }
  return 1;
}

std::optional<StampUnit> UnitOfUnixTime(double number) {
  for (const StampUnit unit : kUnits) {
    const double t_s = number * SecondsIn(unit);
    if (t_s >= kYear2000S && t_s < kYear2100S) return unit;
  }
  return std::nullopt;
}

std::optional<StampUnit> UnitOfInterval(double interval) {
  for (const StampUnit unit : kUnits) {
    const double interval_s = interval * SecondsIn(unit);
    if (interval_s > 1e-3 && interval_s <= 1) return unit;
  }
  return std::nullopt;
}

std::optional<int64_t> ParseStamp(std::string_view text, StampUnit unit) {
  if (unit == StampUnit::kSeconds) return ParseSeconds(text);
  const double per_unit = SecondsIn(unit) * 1e9;
  if (const auto whole = ParseInteger(text)) {
    const double most = kMostStampNs / per_unit;
    if (std::abs(static_cast<double>(*whole)) > most) return std::nullopt;
    return *whole * std::llround(per_unit);
  }
  const auto number = ParseNumber(text);
  if (!number || !(std::abs(*number * per_unit) < kMostStampNs)) return std::nullopt;
  return std::llround(*number * per_unit);
}

double MedianStep(const std::vector<double>& numbers) {
  std::vector<double> steps;
  for (size_t i = 1; i < numbers.size(); ++i) {
    if (numbers[i] > numbers[i - 1]) steps.push_back(numbers[i] - numbers[i - 1]);
  }
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

std::optional<WrongUnit> FindWrongUnit(const std::vector<double>& numbers, StampUnit declared) {
  constexpr double kImpossibleS = 5e-5, kDoubtfulS = 5e-4, kLongS = 500, kFarFutureS = 1e11;
  const double step = MedianStep(numbers);
  if (step == 0) return std::nullopt;
  const double step_s = step * SecondsIn(declared);
  const auto dated = UnitOfUnixTime(numbers.front());
  const bool dated_otherwise = dated && *dated != declared;
  const bool doubtful = step_s < kDoubtfulS || step_s > kLongS;
  const bool far_future = numbers.front() * SecondsIn(declared) > kFarFutureS;
  const bool impossible = step_s < kImpossibleS || far_future;
  if (!impossible && !(dated_otherwise && doubtful)) return std::nullopt;
  const auto implied = dated_otherwise ? dated : UnitOfInterval(step);
  if (!implied || *implied == declared) return std::nullopt;
  const double date = dated_otherwise ? numbers.front() : 0;
  return WrongUnit{*implied, Words(declared, step, 0) + ", " + Words(*implied, step, date)};
}

}  // namespace tagtwist::internal
