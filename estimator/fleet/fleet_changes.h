#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "estimator/fleet/fleet_row.h"

namespace tagtwist::internal {

/// How a figure changed from an old fleet to a new one, over the recordings that both have done.
struct FigureChange {
  size_t figure = 0;         // into Figures()
  size_t recordings = 0;     // with the figure in both
  size_t became_larger = 0;  // of them, by any amount
  double ratio = 1;          // new over old, geometric mean; of kFurtherFromOne of exp |ln figure|
  double low = 1, high = 1;  // its 99 % interval (Student's t)
  double p = 1;              // of a ratio of 1, for all tested figures together (Holm)
  bool is_tested = false;    // enough recordings, and a figure that says what is worse
  bool is_named = false;     // told from chance, and large enough to matter
};

/// A recording that both fleets have, and ends otherwise now.
struct OutcomeChange {
  size_t old_row = 0, new_row = 0;
};

/// A figure of one recording that changed otherwise than those of the others.
struct RecordingChange {
  size_t new_row = 0, figure = 0;
  double ratio = 1;  // new over old, as of FigureChange
};

/// What changed between two fleets.
struct FleetChanges {
  std::string old_place;
  std::vector<FigureChange> figures;    // in the order of Figures()
  std::vector<OutcomeChange> outcomes;  // in the order of the new rows
  std::vector<RecordingChange> single;  // in the order of Figures(), then of the new rows
  std::vector<size_t> old_of_new;       // a new row's old one, or kNoRow
  size_t only_old = 0, only_new = 0;    // rows that the other fleet lacks
  size_t other_tables = 0;              // pairs whose recordings have other tables
  static constexpr size_t kNoRow = static_cast<size_t>(-1);
};

/// Figures are told from chance where fewer than one in a hundred comparisons of fleets that do not
/// differ would name any of them.
constexpr double kFleetLevel = 0.01;
/// And where they changed by more than this: less is nobody's concern.
constexpr double kLeastChange = 0.01;
/// With fewer recordings nothing is said.
constexpr size_t kLeastRecordings = 4;

/// A single recording is named where its figure changed by this factor.
constexpr double kLeastSingleFactor = 2;

/// Rows are paired by name and swept values. Each figure's logarithms are compared pair by pair
/// with Student's t; rows of one recording (a sweep) count as one, their mean. The probabilities
/// are Holm's (Scand. J. Statistics 6, 1979) for all figures that can be tested. A single recording
/// is held against what the others' logarithms foretell (Student's t again), for all recordings and
/// figures together (Bonferroni).
FleetChanges CompareFleets(const Fleet& old_fleet, const Fleet& new_fleet);

/// "flight 7: ATE [mm] 4.1 times what it was, unlike the others: worse".
std::string ChangeText(const RecordingChange& change, const Fleet& new_fleet);

/// "ATE 9.8 % larger (99 %: 6.1 to 13.6 %), in 22 of 24 recordings: worse".
std::string ChangeText(const FigureChange& change);

}  // namespace tagtwist::internal
