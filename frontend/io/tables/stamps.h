#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/io/tables/csv.h"

namespace tagtwist {

/// What the stamps of a file count: "t" of the project's own files, "timestamp" of EuRoC/ASL's.
enum class TimeUnit { kSeconds, kNanoseconds };

/// The stamp in a row of a table; errors name file and line.
Result<int64_t> ReadStamp(const CsvTable& table, size_t row, size_t column, TimeUnit unit);
std::string FormatStamp(int64_t t_ns, TimeUnit unit);

/// Why `t_ns` cannot follow `previous_ns` where stamps grow strictly: "stamp 0.5 repeats", "stamp
/// 0.4 runs backwards, after 0.5"; nullopt when it can.
std::optional<std::string> StampFault(int64_t previous_ns, int64_t t_ns);

/// The stamps of a whole column; refuses those that do not grow strictly.
Result<std::vector<int64_t>> ReadGrowingStamps(const CsvTable& table, size_t column, TimeUnit unit);

/// Index of the stamp nearest to t_ns; the stamps grow and are not empty.
size_t NearestIndex(const std::vector<int64_t>& stamps_ns, int64_t t_ns);

}  // namespace tagtwist
