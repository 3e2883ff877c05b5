#include "frontend/io/tables/stamps.h"

#include <algorithm>

#include "frontend/io/tables/text_grid.h"

namespace tagtwist::internal {
namespace {

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

StampUnit DeclaredUnit(TimeUnit unit) {
  return unit == TimeUnit::kSeconds ? StampUnit::kSeconds : StampUnit::kNanoseconds;
}

std::string WrongUnitNote(const std::string& path, const WrongUnit& wrong) {
  return path + ": its stamps are taken for " + ToString(wrong.implied) + ": " + wrong.words;
}

Result<std::optional<int64_t>> StampColumn::Take(const CsvTable& table, size_t row) {
  if (rows_++ == 0) first_line_ = table.line(row);
  const std::string_view cell = table.Cell(row, column_);
  if (cell == "nan" || cell == "NaN") {
    ++without_;
    return std::optional<int64_t>();
  }
  const auto parsed = implied_ ? ParseStamp(cell, *implied_) : std::nullopt;
  const auto t_ns = parsed ? Result<int64_t>(*parsed) : ReadStamp(table, row, column_, unit_);
  if (!t_ns) return t_ns.error();
  const bool repeats = latest_ns_ && *t_ns == *latest_ns_;
  const bool grows = !latest_ns_ || *t_ns > *latest_ns_;
  const bool stands_with_it = repeats && all_repeats_ && took_last_;
  took_last_ = grows || stands_with_it;
  if (took_last_) {
    ++kept_;
    latest_ns_ = *t_ns;
    return latest_ns_;
  }
  if (passed_over_.All()) first_passed_over_line_ = table.line(row);
  (repeats ? passed_over_.repeated : passed_over_.backward) += 1;
  return std::optional<int64_t>();
}

Result<std::vector<std::string>> StampColumn::Notes(const std::string& path) const {
  std::vector<std::string> out;
  if (without_ > 0) {
    out.push_back(path + ": passed over " + std::to_string(without_) + " rows without a stamp");
  }
  if (!passed_over_.All()) {
    const std::string text = PassedOverText(passed_over_, kept_, "rows",
                                            "line " + std::to_string(first_passed_over_line_));
    if (2 * kept_ <= rows_) {
      return Error{Place(path, first_passed_over_line_) + text + ", too few are left"};
    }
    out.push_back(path + ": " + text);
  }
  if (kept_ == 0 && without_ > 0) return Error{Place(path, first_line_) + "no row has a stamp"};
  return out;
}

Result<TakenStamps> ReadStamps(const CsvTable& table, size_t column, TimeUnit unit,
                               bool all_repeats) {
  TakenStamps out;
  const auto wrong = FindWrongUnit(NumbersOf(table, column), DeclaredUnit(unit));
  if (wrong) out.notes.push_back(WrongUnitNote(table.path(), *wrong));
  StampColumn stamps(column, unit, all_repeats,
                     wrong ? std::optional(wrong->implied) : std::nullopt);
  for (size_t row = 0; row < table.rows(); ++row) {
    const auto t_ns = stamps.Take(table, row);
    if (!t_ns) return t_ns.error();
    if (!*t_ns) continue;
    out.rows.push_back(row);
    out.stamps_ns.push_back(**t_ns);
  }
  const auto notes = stamps.Notes(table.path());
  if (!notes) return notes.error();
  out.notes.insert(out.notes.end(), notes->begin(), notes->end());
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
