#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// "path:line: ", with which a message about a line begins.
inline std::string Place(const std::string& path, int line) {
  return path + ":" + std::to_string(line) + ": ";
}

/// The bytes of a text file as UTF-8 without a byte order mark; UTF-16 is converted. Refused: bytes
/// that are no text.
Result<std::string> DecodeText(std::string bytes, const std::string& path);

/// A table of a text in whatever dialect it was written: cells apart by commas, semicolons, tabs or
/// blanks, with decimal points or decimal commas, with comments from '#' or '%', with a line of
/// names or without. Quotes around cells are taken off; empty lines are passed over.
class TextGrid {
 public:
  struct Row {
    int line = 0;  // counted from 1
    std::vector<std::string_view> cells;
  };

  /// `text` as DecodeText gives it. The first row of numbers decides on the dialect; what stands
  /// before it is the heading. A text without such a row has no rows.
  static TextGrid Parse(std::string text);

  /// Lines before the first row of numbers, comments among them, cut like the rows.
  const std::vector<Row>& heading() const { return heading_; }
  const std::vector<Row>& rows() const { return rows_; }
  char separator() const { return separator_; }  // ' ' stands for any run of blanks
  bool decimal_comma() const { return decimal_comma_; }

 private:
  std::shared_ptr<std::string> text_;  // the cells point into it
  std::vector<Row> heading_, rows_;
  char separator_ = ',';
  bool decimal_comma_ = false;
};

}  // namespace tagtwist::internal
