#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/io/tables/csv.h"
#include "frontend/io/tables/growing_stamps.h"
#include "frontend/io/tables/stamp_unit.h"

namespace tagtwist::internal {

/// What the stamps of a file count: "t" of the project's own files, "timestamp" of EuRoC/ASL's.
enum class TimeUnit { kSeconds, kNanoseconds };

/// The stamp in a row of a table; errors name file and line.
Result<int64_t> ReadStamp(const CsvTable& table, size_t row, size_t column, TimeUnit unit);
std::string FormatStamp(int64_t t_ns, TimeUnit unit);

/// Why `t_ns` cannot follow `previous_ns` where stamps grow strictly: "stamp 0.5 repeats", "stamp
/// 0.4 runs backwards, after 0.5"; nullopt when it can.
std::optional<std::string> StampFault(int64_t previous_ns, int64_t t_ns);

/// The stamps of a column that are taken.
struct TakenStamps {
  std::vector<int64_t> stamps_ns;  // strictly growing
  std::vector<size_t> rows;        // of the table, one a stamp
  std::vector<std::string> notes;  // rows passed over, a unit that is another: a line each
};

/// Passes over rows without a stamp ("nan") and those whose stamps repeat or run backwards, and
/// counts them in the notes. Stamps that cannot be in the unit that the format has (FindWrongUnit)
/// are read in the one that they imply, and that is noted. `all_repeats`: rows of one stamp stand
/// together and are all taken.
Result<TakenStamps> ReadStamps(const CsvTable& table, size_t column, TimeUnit unit,
                               bool all_repeats = false);

/// The stamps of a column row by row, of a table that need not be in memory: ReadStamps is made of
/// these.
class StampColumn {
 public:
  /// `implied`: the unit that FindWrongUnit names, where it does.
  StampColumn(size_t column, TimeUnit unit, bool all_repeats, std::optional<StampUnit> implied)
      : column_(column), unit_(unit), all_repeats_(all_repeats), implied_(implied) {}

  /// Of the next row: its stamp, or nullopt where it is passed over.
  Result<std::optional<int64_t>> Take(const CsvTable& table, size_t row);
  /// After the last: what was passed over, a line each, with the file's name; an error where too
  /// few are left.
  Result<std::vector<std::string>> Notes(const std::string& path) const;

 private:
  size_t column_;
  TimeUnit unit_;
  bool all_repeats_;
  std::optional<StampUnit> implied_;
  std::optional<int64_t> latest_ns_;  // of those that were taken
  bool took_last_ = false;            // rows of one stamp stand together
  GrowingStamps passed_over_;         // without `kept`
  size_t rows_ = 0, kept_ = 0, without_ = 0;
  int first_line_ = 0, first_passed_over_line_ = 0;
};

/// What a file's stamps count by its format.
StampUnit DeclaredUnit(TimeUnit unit);
/// "x.csv: its stamps are taken for seconds: WHY".
std::string WrongUnitNote(const std::string& path, const WrongUnit& wrong);

/// True where one of the cells is "nan": a row that says nothing.
bool HasNan(const CsvTable& table, size_t row, const std::vector<size_t>& columns);

/// Index of the stamp nearest to t_ns; the stamps grow and are not empty.
size_t NearestIndex(const std::vector<int64_t>& stamps_ns, int64_t t_ns);

}  // namespace tagtwist::internal
