#include "estimator/fleet/fleet_changes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/fleets.h"

namespace tagtwist::internal::fleet_changes_test {
namespace {

using ::testing::HasSubstr;

// How many figures are named worse, and better.
std::pair<int, int> NamedIn(const FleetChanges& changes) {
  std::pair<int, int> out;
  for (const FigureChange& change : changes.figures) {
    if (change.is_named) ++(change.ratio > 1 ? out.first : out.second);
  }
  return out;
}

TEST(FleetChanges, NoiseATenthLargerIsNamedWithTheRightSign) {
  int named = 0;
  for (uint64_t draw = 0; draw < 20; ++draw) {
    const auto [worse, better] =
        NamedIn(CompareFleets(DrawFleet(12, 1, 2 * draw), DrawFleet(12, 1.1, 2 * draw + 1)));
    named += worse > 0 && better == 0 ? 1 : 0;
  }
  EXPECT_GE(named, 19);
}

TEST(FleetChanges, SmallerNoiseIsBetter) {
  const FleetChanges changes = CompareFleets(DrawFleet(12, 1.1, 7), DrawFleet(12, 1, 8));
  const auto [worse, better] = NamedIn(changes);
  EXPECT_EQ(worse, 0);
  EXPECT_GE(better, 3);
  const std::string text = ChangeText(changes.figures[FigureIndex("corner_sigma_px")]);
  EXPECT_THAT(text, HasSubstr("corner noise [px] "));
  EXPECT_THAT(text, HasSubstr(" % smaller (99 %: "));
  EXPECT_THAT(text, HasSubstr("in 12 of 12 recordings: better"));
}

// The rate of the whole family, of fleets that differ in nothing but their draws.
TEST(FleetChanges, ChanceIsNamedInOneOfAHundredComparisons) {
  for (const size_t recordings : {size_t{5}, size_t{24}}) {
    int named = 0, single = 0;
    constexpr int kDraws = 1000;
    for (uint64_t draw = 0; draw < kDraws; ++draw) {
      const FleetChanges changes =
          CompareFleets(DrawFleet(recordings, 1, 2 * draw), DrawFleet(recordings, 1, 2 * draw + 1));
      named += NamedIn(changes) != std::pair(0, 0) ? 1 : 0;
      single += changes.single.empty() ? 0 : 1;
    }
    EXPECT_LE(single, 0.01 * kDraws) << recordings;
    EXPECT_LE(named, 0.02 * kDraws) << recordings;  // 10 expected, sigma 3.2
    EXPECT_GE(named, 3) << recordings << ": a test that never speaks proves nothing";
  }
}

TEST(FleetChanges, TheSameBytesDifferInNothing) {
  const Fleet fleet = DrawFleet(24, 1, 3);
  const FleetChanges changes = CompareFleets(fleet, fleet);
  EXPECT_EQ(NamedIn(changes), std::pair(0, 0));
  for (const FigureChange& change : changes.figures) EXPECT_EQ(change.p, 1);
  EXPECT_TRUE(changes.outcomes.empty());
}

// Slower and with more memory on a busy machine: nothing of ours.
TEST(FleetChanges, TimeAndMemoryAreNotNamed) {
  const Fleet old_fleet = DrawFleet(24, 1, 3);
  Fleet new_fleet = old_fleet;
  for (FleetRow& row : new_fleet.rows) {
    row.figures[FigureIndex("wall_s")] *= 3;
    row.figures[FigureIndex("peak_rss_mib")] *= 3;
  }
  const FleetChanges changes = CompareFleets(old_fleet, new_fleet);
  EXPECT_EQ(NamedIn(changes), std::pair(0, 0));
  EXPECT_NEAR(changes.figures[FigureIndex("wall_s")].ratio, 3, 1e-9);
}

// However surely it is told from chance: a tenth of a per cent is nobody's concern.
TEST(FleetChanges, WhatIsTooSmallToMatterIsNotNamed) {
  const Fleet old_fleet = DrawFleet(24, 1, 3);
  Fleet new_fleet = old_fleet;
  for (FleetRow& row : new_fleet.rows) row.figures[0] *= 1.001;
  EXPECT_EQ(NamedIn(CompareFleets(old_fleet, new_fleet)), std::pair(0, 0));
  for (FleetRow& row : new_fleet.rows) row.figures[0] *= 1.02;
  EXPECT_EQ(NamedIn(CompareFleets(old_fleet, new_fleet)), std::pair(1, 0));
}

// One recording that is much worse is no change of the fleet: it is named by itself.
TEST(FleetChanges, OneOutlierIsNamedByItself) {
  for (const uint64_t draw : {3u, 4u}) {  // the same bytes besides, and another draw
    const Fleet old_fleet = DrawFleet(24, 1, 3);
    Fleet new_fleet = DrawFleet(24, 1, draw);
    new_fleet.rows[5].figures[0] *= 50;
    const FleetChanges changes = CompareFleets(old_fleet, new_fleet);
    EXPECT_EQ(NamedIn(changes), std::pair(0, 0));
    ASSERT_EQ(changes.single.size(), 1u);
    EXPECT_EQ(changes.single[0].new_row, 5u);
    EXPECT_EQ(changes.single[0].figure, 0u);
    EXPECT_GT(changes.single[0].ratio, 20);
    EXPECT_THAT(ChangeText(changes.single[0], new_fleet), HasSubstr("flight 5: ATE [mm] "));
  }
}

// All twice as large: that is the fleet's change, and none of its recordings'.
TEST(FleetChanges, WhatAllDoIsNamedOfNoRecording) {
  const FleetChanges changes = CompareFleets(DrawFleet(24, 1, 3), DrawFleet(24, 2.5, 4));
  EXPECT_GE(NamedIn(changes).first, 5);
  EXPECT_TRUE(changes.single.empty());
}

// Nine values of a flag are not nine recordings.
TEST(FleetChanges, RowsOfOneRecordingCountAsOne) {
  Fleet old_fleet, new_fleet;
  for (int value = 0; value < 9; ++value) {
    for (auto [fleet, noise] : {std::pair(&old_fleet, 1.0), std::pair(&new_fleet, 1.1)}) {
      for (FleetRow row : DrawFleet(3, noise, 4).rows) {
        row.values = {{"corner_sigma_px", std::to_string(value)}};
        fleet->rows.push_back(row);
      }
    }
  }
  const FleetChanges changes = CompareFleets(old_fleet, new_fleet);
  EXPECT_EQ(changes.figures[0].recordings, 3u);
  EXPECT_EQ(NamedIn(changes), std::pair(0, 0));  // fewer than kLeastRecordings
}

// NEES of 1.5 is as bad as one of 1 / 1.5; from 0.5 to 0.9 it becomes better.
TEST(FleetChanges, NeesCountsByItsDistanceFromOne) {
  Fleet old_fleet = DrawFleet(24, 1, 3), new_fleet = old_fleet;
  const size_t nees = FigureIndex("nees_per_dof");
  RandomStream draw(9);
  for (size_t i = 0; i < 24; ++i) {
    old_fleet.rows[i].figures[nees] = 0.5 * std::exp(0.02 * draw.Normal());
    new_fleet.rows[i].figures[nees] = 0.9 * std::exp(0.02 * draw.Normal());
  }
  const FleetChanges changes = CompareFleets(old_fleet, new_fleet);
  EXPECT_EQ(NamedIn(changes), std::pair(0, 1));
  EXPECT_THAT(ChangeText(changes.figures[nees]), HasSubstr("nearer to 1"));
}

TEST(FleetChanges, OutcomesAndRowsThatOneFleetLacksAreTold) {
  const Fleet old_fleet = DrawFleet(6, 1, 3);
  Fleet new_fleet = DrawFleet(7, 1, 3);
  new_fleet.rows.erase(new_fleet.rows.begin());
  new_fleet.rows[1].outcome = FleetOutcome::kFailed;
  const FleetChanges changes = CompareFleets(old_fleet, new_fleet);
  ASSERT_EQ(changes.outcomes.size(), 1u);
  EXPECT_EQ(changes.outcomes[0].new_row, 1u);
  EXPECT_EQ(changes.outcomes[0].old_row, 2u);
  EXPECT_EQ(changes.only_new, 1u);
  EXPECT_EQ(changes.only_old, 1u);
  EXPECT_EQ(changes.figures[0].recordings, 4u);
}

}  // namespace
}  // namespace tagtwist::internal::fleet_changes_test
