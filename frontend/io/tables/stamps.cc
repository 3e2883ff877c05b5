#include "frontend/io/tables/stamps.h"

#include <algorithm>

namespace tagtwist {

Result<int64_t> ReadStamp(const CsvTable& table, size_t row, size_t column, TimeUnit unit) {
  return unit == TimeUnit::kSeconds ? table.Seconds(row, column) : table.Integer(row, column);
}

std::string FormatStamp(int64_t t_ns, TimeUnit unit) {
  return unit == TimeUnit::kSeconds ? FormatSeconds(t_ns) : std::to_string(t_ns);
}

std::optional<std::string> StampFault(int64_t previous_ns, int64_t t_ns) {
  if (t_ns > previous_ns) return std::nullopt;
  const std::string stamp = "stamp " + FormatSeconds(t_ns) + " s ";
  if (t_ns == previous_ns) return stamp + "repeats";
  return stamp + "runs backwards, after " + FormatSeconds(previous_ns) + " s";
}

Result<std::vector<int64_t>> ReadGrowingStamps(const CsvTable& table, size_t column,
                                               TimeUnit unit) {
  std::vector<int64_t> out;
  out.reserve(table.rows());
  for (size_t row = 0; row < table.rows(); ++row) {
    const auto t_ns = ReadStamp(table, row, column, unit);
    if (!t_ns) return t_ns.error();
    if (!out.empty()) {
      if (const auto fault = StampFault(out.back(), *t_ns)) return table.ErrorAt(row, *fault);
    }
    out.push_back(*t_ns);
  }
  return out;
}

size_t NearestIndex(const std::vector<int64_t>& stamps_ns, int64_t t_ns) {
  const auto after = std::lower_bound(stamps_ns.begin(), stamps_ns.end(), t_ns);
  const auto index = static_cast<size_t>(after - stamps_ns.begin());
  if (index == 0) return 0;
  if (index == stamps_ns.size()) return index - 1;
  return t_ns - stamps_ns[index - 1] <= stamps_ns[index] - t_ns ? index - 1 : index;
}

}  // namespace tagtwist
