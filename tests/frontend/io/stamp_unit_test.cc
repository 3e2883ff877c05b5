#include "frontend/io/tables/stamp_unit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace tagtwist::internal::stamp_unit_test {
namespace {

using ::testing::HasSubstr;

std::vector<double> Stamps(double first, double interval) {
  std::vector<double> out;
  for (int i = 0; i < 20; ++i) out.push_back(first + interval * i);
  return out;
}

constexpr double kUnixS = 1.4e9, kUptimeS = 9000;

// Whatever a recording's rate and clock, stamps in the declared unit are never accused.
TEST(StampUnit, RightStampsAreLeftAlone) {
  for (const StampUnit unit : {StampUnit::kSeconds, StampUnit::kNanoseconds}) {
    const double per_second = 1 / SecondsIn(unit);
    for (const double first_s : {0.0, kUptimeS, 30 * 86400.0, kUnixS}) {
      for (const double rate_hz : {0.01, 0.1, 1.0, 5.0, 30.0, 1000.0, 1900.0}) {
        const auto wrong = FindWrongUnit(Stamps(first_s * per_second, per_second / rate_hz), unit);
        const bool accused = wrong.has_value();
        EXPECT_FALSE(accused) << ToString(unit) << " " << first_s << " s " << rate_hz
                              << " Hz: " << (wrong ? wrong->words : "");
      }
    }
  }
}

// Dates in another unit, at every rate that cameras have.
TEST(StampUnit, DatesInAnotherUnitAreFound) {
  for (const StampUnit declared : {StampUnit::kSeconds, StampUnit::kNanoseconds}) {
    for (const StampUnit meant : {StampUnit::kSeconds, StampUnit::kMilliseconds,
                                  StampUnit::kMicroseconds, StampUnit::kNanoseconds}) {
      if (meant == declared) continue;
      for (const double rate_hz : {5.0, 30.0, 200.0}) {
        const double per_second = 1 / SecondsIn(meant);
        const auto wrong =
            FindWrongUnit(Stamps(kUnixS * per_second, per_second / rate_hz), declared);
        ASSERT_TRUE(wrong) << ToString(declared) << " for " << ToString(meant) << " " << rate_hz;
        EXPECT_EQ(wrong->implied, meant);
        EXPECT_THAT(wrong->words, HasSubstr("in 2014"));
      }
    }
  }
}

TEST(StampUnit, ImpossibleRatesAreFoundWithoutADate) {
  const auto wrong = FindWrongUnit(Stamps(0, 33333), StampUnit::kNanoseconds);
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->implied, StampUnit::kMicroseconds);
  EXPECT_THAT(wrong->words, HasSubstr("as microseconds they come at 30 Hz"));
}

}  // namespace
}  // namespace tagtwist::internal::stamp_unit_test
