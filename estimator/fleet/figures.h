#pragma once
#include <cstddef>
#include <vector>

namespace tagtwist::internal {

/// A figure of a run: its place in summary.json, and how it is told.
struct Figure {
  const char* key;      // in fleet.csv and fleet.json, SI units: "position_rmse_m"
  const char* pointer;  // into summary.json (RFC 6901)
  const char* title;    // of its column: "ATE"
  const char* unit;     // that people read: "mm"
  double scale;         // of SI units to that unit
  /// What says that a run became worse. Of kNone nothing is said: it depends on what else the
  /// machine does.
  enum class Worse { kLarger, kFurtherFromOne, kNone } worse;
};

/// All of them, in the order of the columns.
const std::vector<Figure>& Figures();

/// The place in Figures(), which has it.
size_t FigureIndex(const char* key);

}  // namespace tagtwist::internal
