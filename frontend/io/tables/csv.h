#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "frontend/base/files/input_file.h"
#include "frontend/base/limits.h"
#include "frontend/base/number_text.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A text of comma-separated values with a header line, read strictly: every row has as many cells
/// as the header, empty lines stand at the end only. Accepts CRLF, spaces around cells, and
/// the header of EuRoC/ASL files: "#timestamp [ns],p_RS_R_x [m]" names the columns "timestamp" and
/// "p_RS_R_x" (units in brackets are left out). No quoting.
/// Errors read "file:line: what was expected and what is there".
class CsvTable {
 public:
  static Result<CsvTable> Read(const std::string& path, const Limits& limits = {});
  /// `path` is for messages only.
  static Result<CsvTable> Parse(std::string text, const std::string& path);

  const std::string& path() const { return path_; }
  const std::vector<std::string>& columns() const { return columns_; }
  size_t rows() const { return rows_.size(); }
  int line(size_t row) const { return rows_[row].line; }

  std::optional<size_t> FindColumn(std::string_view name) const;
  /// Column numbers in the order of the names; "file:1: missing column 'qx'".
  Result<std::vector<size_t>> RequireColumns(const std::vector<std::string>& names) const;

  std::string_view Cell(size_t row, size_t column) const;
  /// Finite numbers only: "file:7: vx_world: expected a finite number, got 'nan'".
  Result<double> Number(size_t row, size_t column) const;
  Result<std::vector<double>> Numbers(size_t row, const std::vector<size_t>& columns) const;
  Result<int64_t> Integer(size_t row, size_t column) const;
  /// Decimal seconds to nanoseconds; see ParseSeconds.
  Result<int64_t> Seconds(size_t row, size_t column) const;

  /// "file:line: message", for what a caller finds wrong in a row.
  Error ErrorAt(size_t row, const std::string& message) const;

 private:
  friend class CsvPieces;
  struct Row {
    int line;           // counted from 1
    size_t first_cell;  // in cells_
  };
  // The next line of the text, which stays where it is.
  std::optional<Error> ParseLine(std::string_view line);
  Error CellError(size_t row, size_t column, const std::string& expected) const;
  std::optional<Error> ParseHeader(std::string_view line, int line_number);
  std::optional<Error> ParseRow(std::string_view line, int line_number);

  std::string path_;
  std::shared_ptr<const std::string> text_;  // cells_ point into it
  std::vector<std::string> columns_;
  std::vector<Row> rows_;
  std::vector<std::string_view> cells_;
  int lines_ = 0;       // that were parsed
  int empty_line_ = 0;  // the first one; 0: none
};

/// The rows of such a file, some at a time, in order, as often as one likes: nothing else of it is
/// in memory.
class CsvPieces {
 public:
  /// Reads the header line.
  static Result<CsvPieces> Open(const std::string& path, const Limits& limits = {});

  /// The next rows, in a table that has the file's columns and lines, until the next call; nullptr
  /// at the end. An error where one of the lines is none: CsvTable's.
  Result<const CsvTable*> Next();
  /// From the first row again.
  Status Rewind();
  /// The columns; rows as Next says.
  const CsvTable& table() const { return table_; }

 private:
  explicit CsvPieces(PiecewiseFile file) : file_(std::move(file)) {}
  // Forgets the lines that were parsed, and reads until there is another; false at the end.
  Result<bool> ReadLines();
  // The next of these lines; nullopt where they are at their end.
  std::optional<std::string_view> TakeLine();

  PiecewiseFile file_;
  CsvTable table_;
  std::shared_ptr<std::string> text_ = std::make_shared<std::string>();
  size_t taken_ = 0;  // bytes of text_ that were parsed
  bool at_end_ = false;
};

}  // namespace tagtwist::internal
