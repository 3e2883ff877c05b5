#include "frontend/io/tables/csv.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "frontend/base/files/input_file.h"
#include "frontend/io/tables/trim.h"

namespace tagtwist::internal {
namespace {

// "p_RS_R_x [m]" -> "p_RS_R_x"
std::string_view WithoutUnit(std::string_view name) {
  if (name.empty() || name.back() != ']') return name;
  const size_t bracket = name.rfind('[');
  return bracket == std::string_view::npos ? name : Trim(name.substr(0, bracket));
}

// Calls take(cell) for every comma-separated cell of the line, trimmed.
template <typename Take>
void ForEachCell(std::string_view line, const Take& take) {
  for (;;) {
    const size_t comma = line.find(',');
    take(Trim(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

Error LineError(const std::string& path, int line, const std::string& message) {
  return Error{path + ":" + std::to_string(line) + ": " + message};
}

Error EmptyFile(const std::string& path) { return Error{path + ": empty file"}; }

}  // namespace

Result<CsvTable> CsvTable::Read(const std::string& path, const Limits& limits) {
  auto text = ReadWholeFile(path, limits);
  if (!text) return text.error();
  return Parse(std::move(*text), path);
}

Result<CsvTable> CsvTable::Parse(std::string text, const std::string& path) {
  CsvTable table;
  table.path_ = path;
  table.text_ = std::make_shared<const std::string>(std::move(text));
  std::string_view rest = *table.text_;
  while (!rest.empty()) {
    const size_t end = rest.find('\n');
    if (const auto problem = table.ParseLine(rest.substr(0, end))) return *problem;
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
  if (table.columns_.empty()) return EmptyFile(path);
  return table;
}

std::optional<Error> CsvTable::ParseLine(std::string_view line) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (++lines_ == 1 && line.substr(0, kByteOrderMark.size()) == kByteOrderMark) {
    line.remove_prefix(kByteOrderMark.size());
  }
  line = Trim(line);
  if (line.empty()) {
    if (empty_line_ == 0) empty_line_ = lines_;
    return std::nullopt;
  }
  if (empty_line_ != 0) return LineError(path_, empty_line_, "expected a row, got an empty line");
  return columns_.empty() ? ParseHeader(line, lines_) : ParseRow(line, lines_);
}

std::optional<Error> CsvTable::ParseHeader(std::string_view line, int line_number) {
  if (line.front() == '#') line = Trim(line.substr(1));
  ForEachCell(line, [this](std::string_view cell) { columns_.emplace_back(WithoutUnit(cell)); });
  if (ParseNumber(columns_.front())) {
    return LineError(path_, line_number, "expected a header line with the columns' names");
  }
  std::unordered_set<std::string_view> names;
  for (const std::string& name : columns_) {
    if (!name.empty() && !names.insert(name).second) {
      return LineError(path_, line_number, "column " + QuoteForMessage(name) + " appears twice");
    }
  }
  return std::nullopt;
}

std::optional<Error> CsvTable::ParseRow(std::string_view line, int line_number) {
  const size_t first_cell = cells_.size();
  ForEachCell(line, [this](std::string_view cell) { cells_.push_back(cell); });
  rows_.push_back({line_number, first_cell});
  const size_t got = cells_.size() - first_cell;
  if (got == columns_.size()) return std::nullopt;
  return LineError(
      path_, line_number,
      "expected " + std::to_string(columns_.size()) + " columns, got " + std::to_string(got));
}

std::optional<size_t> CsvTable::FindColumn(std::string_view name) const {
  const auto found = std::find(columns_.begin(), columns_.end(), name);
  if (found == columns_.end()) return std::nullopt;
  return static_cast<size_t>(found - columns_.begin());
}

Result<std::vector<size_t>> CsvTable::RequireColumns(const std::vector<std::string>& names) const {
  std::vector<size_t> out;
  for (const std::string& name : names) {
    const auto column = FindColumn(name);
    if (!column) return LineError(path_, 1, "missing column '" + name + "'");
    out.push_back(*column);
  }
  return out;
}

std::string_view CsvTable::Cell(size_t row, size_t column) const {
  return cells_[rows_[row].first_cell + column];
}

Result<double> CsvTable::Number(size_t row, size_t column) const {
  const auto value = ParseNumber(Cell(row, column));
  if (!value) return CellError(row, column, "a finite number");
  return *value;
}

Result<std::vector<double>> CsvTable::Numbers(size_t row,
                                              const std::vector<size_t>& columns) const {
  std::vector<double> out;
  out.reserve(columns.size());
  for (const size_t column : columns) {
    const auto value = ParseNumber(Cell(row, column));
    if (!value) return CellError(row, column, "a finite number");
    out.push_back(*value);
  }
  return out;
}

Result<int64_t> CsvTable::Integer(size_t row, size_t column) const {
  const auto value = ParseInteger(Cell(row, column));
  if (!value) return CellError(row, column, "an integer");
  return *value;
}

Result<int64_t> CsvTable::Seconds(size_t row, size_t column) const {
  const auto value = ParseSeconds(Cell(row, column));
  if (!value) return CellError(row, column, "a time in seconds");
  return *value;
}

Error CsvTable::CellError(size_t row, size_t column, const std::string& expected) const {
  return ErrorAt(row, columns_[column] + ": expected " + expected + ", got " +
                          QuoteForMessage(Cell(row, column)));
}

Error CsvTable::ErrorAt(size_t row, const std::string& message) const {
  return LineError(path_, line(row), message);
}

Result<CsvPieces> CsvPieces::Open(const std::string& path, const Limits& limits) {
  auto file = PiecewiseFile::Open(path, limits);
  if (!file) return file.error();
  CsvPieces out(std::move(*file));
  out.table_.path_ = path;
  if (const Status header = out.Rewind(); !header) return header.error();
  return out;
}

Status CsvPieces::Rewind() {
  const std::string path = table_.path_;
  table_ = CsvTable();
  table_.path_ = path;
  table_.text_ = text_;
  file_.Rewind();
  text_->clear();
  taken_ = 0;
  at_end_ = false;
  while (table_.columns_.empty()) {
    const auto line = TakeLine();
    if (line) {
      if (const auto problem = table_.ParseLine(*line)) return *problem;
      continue;
    }
    const auto more = ReadLines();
    if (!more) return more.error();
    if (!*more) return EmptyFile(path);
  }
  return Ok();
}

Result<const CsvTable*> CsvPieces::Next() {
  table_.rows_.clear();
  table_.cells_.clear();
  while (true) {
    while (const auto line = TakeLine()) {
      if (const auto problem = table_.ParseLine(*line)) return *problem;
    }
    if (table_.rows() > 0) return static_cast<const CsvTable*>(&table_);
    const auto more = ReadLines();
    if (!more) return more.error();
    if (!*more) return static_cast<const CsvTable*>(nullptr);
  }
}

Result<bool> CsvPieces::ReadLines() {
  text_->erase(0, taken_);
  taken_ = 0;
  while (!at_end_) {
    const size_t before = text_->size();
    const auto more = file_.AppendTo(text_.get());
    if (!more) return more.error();
    at_end_ = !*more;
    if (text_->find('\n', before) != std::string::npos) break;
  }
  return !text_->empty();
}

std::optional<std::string_view> CsvPieces::TakeLine() {
  const std::string_view rest = std::string_view(*text_).substr(taken_);
  const size_t end = rest.find('\n');
  if (rest.empty() || (end == std::string_view::npos && !at_end_)) return std::nullopt;
  taken_ = end == std::string_view::npos ? text_->size() : taken_ + end + 1;
  return rest.substr(0, end);
}

}  // namespace tagtwist::internal
