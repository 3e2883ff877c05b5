#include "frontend/io/tables/stamps.h"

#include <algorithm>
#include <utility>

#include "frontend/io/tables/growing_stamps.h"
#include "frontend/io/tables/stamp_unit.h"

namespace tagtwist::internal {
namespace {

StampUnit Declared(TimeUnit unit) {
  return unit == TimeUnit::kSeconds ? StampUnit::kSeconds : StampUnit::kNanoseconds;
}

std::vector<double> NumbersOf(const CsvTable& table, size_t column) {
  std::vector<double> out;
  for (size_t row = 0; row < table.rows(); ++row) {
    if (const auto number = ParseNumber(table.Cell(row, column))) out.push_back(*number);
  }
  return out;
}

}  // namespace

Result<int64_t> ReadStamp(const CsvTable& table, size_t row, size_t column, TimeUnit unit) {
  if (unit == TimeUnit::kSeconds) return table.Seconds(row, column);
  auto t_ns = table.Integer(row, column);
  if (!t_ns || (*t_ns <= kMostStampNs && *t_ns >= -kMostStampNs)) return t_ns;
  return table.ErrorAt(
      row, "expected a stamp in nanoseconds, got " + QuoteForMessage(table.Cell(row, column)));
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

Result<TakenStamps> ReadStamps(const CsvTable& table, size_t column, TimeUnit unit,
                               bool all_repeats) {
  TakenStamps out;
  std::optional<StampUnit> other;
  if (const auto wrong = FindWrongUnit(NumbersOf(table, column), Declared(unit))) {
    other = wrong->implied;
    out.notes.push_back(table.path() + ": its stamps are taken for " + ToString(wrong->implied) +
                        ": " + wrong->words);
  }
  GrowingStamps growing;
  size_t without = 0;
  bool took_last = false;  // rows of one stamp stand together
  for (size_t row = 0; row < table.rows(); ++row) {
    const std::string_view cell = table.Cell(row, column);
    if (cell == "nan" || cell == "NaN") {
      ++without;
      continue;
    }
    const auto parsed = other ? ParseStamp(cell, *other) : std::nullopt;
    const auto t_ns = parsed ? Result<int64_t>(*parsed) : ReadStamp(table, row, column, unit);
    if (!t_ns) return t_ns.error();
    const bool repeats = !out.stamps_ns.empty() && *t_ns == out.stamps_ns.back();
    const bool grows = out.stamps_ns.empty() || *t_ns > out.stamps_ns.back();
    const bool stands_with_it = repeats && all_repeats && took_last;
    took_last = grows || stands_with_it;
    if (took_last) {
      growing.kept.push_back(row);
      out.stamps_ns.push_back(*t_ns);
    } else {
      if (growing.All()) growing.first_passed_over = row;
      (repeats ? growing.repeated : growing.backward) += 1;
    }
  }
  if (without > 0) {
    out.notes.push_back(table.path() + ": passed over " + std::to_string(without) +
                        " rows without a stamp");
  }
  if (!growing.All()) {
    const std::string text = PassedOverText(
        growing, "rows", "line " + std::to_string(table.line(growing.first_passed_over)));
    if (2 * growing.kept.size() <= table.rows()) {
      return table.ErrorAt(growing.first_passed_over, text + ", too few are left");
    }
    out.notes.push_back(table.path() + ": " + text);
  }
  if (out.stamps_ns.empty() && without > 0) return table.ErrorAt(0, "no row has a stamp");
  out.rows = std::move(growing.kept);
  return out;
}

bool HasNan(const CsvTable& table, size_t row, const std::vector<size_t>& columns) {
  return std::any_of(columns.begin(), columns.end(), [&](size_t column) {
    const std::string_view cell = table.Cell(row, column);
    return cell == "nan" || cell == "NaN" || cell == "-nan";
  });
}

size_t NearestIndex(const std::vector<int64_t>& stamps_ns, int64_t t_ns) {
  const auto after = std::lower_bound(stamps_ns.begin(), stamps_ns.end(), t_ns);
  const auto index = static_cast<size_t>(after - stamps_ns.begin());
  if (index == 0) return 0;
  if (index == stamps_ns.size()) return index - 1;
  return t_ns - stamps_ns[index - 1] <= stamps_ns[index] - t_ns ? index - 1 : index;
}

}  // namespace tagtwist::internal
