#include "frontend/io/tables/text_grid.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include "frontend/base/number_text.h"
#include "frontend/io/tables/trim.h"

namespace tagtwist::internal {
namespace {

std::string_view WithoutQuotes(std::string_view cell) {
  const bool quoted = cell.size() >= 2 && (cell.front() == '"' || cell.front() == '\'') &&
                      cell.back() == cell.front();
  return quoted ? Trim(cell.substr(1, cell.size() - 2)) : cell;
}

std::vector<std::string_view> Cut(std::string_view line, char separator) {
  std::vector<std::string_view> out;
  if (separator == ' ') {
    for (line = Trim(line); !line.empty();) {
      const size_t end = std::min(line.find_first_of(kBlanks), line.size());
      out.push_back(WithoutQuotes(line.substr(0, end)));
      line = Trim(line.substr(end));
    }
    return out;
  }
  for (;;) {
    const size_t end = line.find(separator);
    out.push_back(WithoutQuotes(Trim(line.substr(0, end))));
    if (end == std::string_view::npos) return out;
    line.remove_prefix(end + 1);
  }
}

bool IsComment(std::string_view trimmed) { return trimmed[0] == '#' || trimmed[0] == '%'; }

// "1", "-0.5", "0,5", "nan": what a row of numbers begins with.
bool BeginsLikeNumber(std::string_view cell) {
  std::string text(cell);
  std::replace(text.begin(), text.end(), ',', '.');
  if (ParseNumber(text)) return true;
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text == "nan" || text == "-nan";
}

struct Dialect {
  char separator;
  bool decimal_comma;
};

bool AnyHasComma(const std::vector<std::string_view>& cells) {
  return std::any_of(cells.begin(), cells.end(), [](std::string_view cell) {
    return cell.find(',') != std::string_view::npos;
  });
}

// The dialect under which the line is a row of numbers, or nullopt: one that has a number in front
// and, where commas stand in its cells, one comma a number.
std::optional<Dialect> DialectOf(std::string_view line) {
  for (const char separator : {';', '\t', ' ', ','}) {
    const auto cells = Cut(line, separator);
    if (cells.size() < 2 || !BeginsLikeNumber(cells[0])) continue;
    const bool commas = separator != ',' && AnyHasComma(cells);
    const bool comma_ends_a_cell = std::any_of(cells.begin(), cells.end(), [](auto cell) {
      return !cell.empty() && (cell.back() == ',' || cell.front() == ',');
    });
    const bool all_numbers = std::all_of(cells.begin(), cells.end(), [](auto cell) {
      return cell.find(',') == std::string_view::npos || BeginsLikeNumber(cell);
    });
    const bool mixed = separator == '\t' && std::any_of(cells.begin(), cells.end(), [](auto cell) {
                         return cell.find(' ') != std::string_view::npos;
                       });
    if (mixed || (separator != ',' && (comma_ends_a_cell || !all_numbers))) continue;
    return Dialect{separator, commas};
  }
  return std::nullopt;
}

void AppendUtf8(uint32_t code, std::string* out) {
  if (code < 0x80) {
    *out += static_cast<char>(code);
  } else if (code < 0x800) {
    *out += static_cast<char>(0xC0 | (code >> 6));
    *out += static_cast<char>(0x80 | (code & 0x3F));
  } else {
    *out += static_cast<char>(0xE0 | (code >> 12));
    *out += static_cast<char>(0x80 | ((code >> 6) & 0x3F));
    *out += static_cast<char>(0x80 | (code & 0x3F));
  }
}

// Of the first plane alone; halves of pairs become one odd sign each, which no number has.
std::string FromUtf16(std::string_view bytes, bool little_end_first) {
  std::string out;
  for (size_t i = 0; i + 1 < bytes.size(); i += 2) {
    const auto first = static_cast<uint8_t>(bytes[i]), second = static_cast<uint8_t>(bytes[i + 1]);
    AppendUtf8(little_end_first ? first | (uint32_t{second} << 8) : second | (uint32_t{first} << 8),
               &out);
  }
  return out;
}

}  // namespace

Result<std::string> DecodeText(std::string bytes, const std::string& path) {
  const std::string_view view = bytes;
  if (view.substr(0, 2) == "\xFF\xFE") return FromUtf16(view.substr(2), true);
  if (view.substr(0, 2) == "\xFE\xFF") return FromUtf16(view.substr(2), false);
  if (view.find('\0') != std::string_view::npos) {
    return Error{path + ": expected a text, got bytes that are none"};
  }
  if (view.substr(0, 3) == "\xEF\xBB\xBF") bytes.erase(0, 3);
  return bytes;
}

TextGrid TextGrid::Parse(std::string text) {
  TextGrid grid;
  grid.text_ = std::make_shared<std::string>(std::move(text));
  std::optional<Dialect> dialect;
  std::vector<std::pair<int, std::string_view>> before;  // lines ahead of the numbers
  const auto for_each_line = [&](const auto& take) {
    std::string_view rest = *grid.text_;
    for (int number = 1; !rest.empty(); ++number) {
      const size_t end = std::min(rest.find('\n'), rest.size());
      const std::string_view line = rest.substr(0, end), trimmed = Trim(line);
      rest.remove_prefix(std::min(end + 1, rest.size()));
      if (!trimmed.empty() && !take(number, line, trimmed)) return;
    }
  };
  size_t numbers_begin = 0;
  for_each_line([&](int, std::string_view line, std::string_view trimmed) {
    if (!IsComment(trimmed)) dialect = DialectOf(trimmed);
    numbers_begin = static_cast<size_t>(line.data() - grid.text_->data());
    return !dialect;
  });
  if (dialect) {
    grid.separator_ = dialect->separator;
    grid.decimal_comma_ = dialect->decimal_comma;
  }
  if (grid.decimal_comma_) {
    std::replace(grid.text_->begin() + static_cast<std::ptrdiff_t>(numbers_begin),
                 grid.text_->end(), ',', '.');
  }
  bool in_rows = false;
  for_each_line([&](int number, std::string_view line, std::string_view trimmed) {
    in_rows = in_rows || (dialect && line.data() == grid.text_->data() + numbers_begin);
    if (in_rows && IsComment(trimmed)) return true;
    Row row{number, Cut(trimmed, grid.separator_)};
    if (in_rows && grid.separator_ != ' ' && row.cells.size() > 1 && row.cells.back().empty()) {
      row.cells.pop_back();  // a separator ends the line
    }
    (in_rows ? grid.rows_ : grid.heading_).push_back(std::move(row));
    return true;
  });
  return grid;
}

}  // namespace tagtwist::internal
